#include "motion/route.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support/error_text.h"

namespace rubble::arena_sim {
namespace {

/// Without what only takes time to draw.
WorldConfig bare() {
  WorldConfig config;
  config.victims = config.hazard_labels = config.qr_codes = config.april_tags = 0;
  return config;
}

WorldConfig flat() {
  WorldConfig config = bare();
  config.crossing = false;
  config.ramp_fields = false;
  return config;
}

std::vector<common::Pose2> fromAbove(const Motion& motion) {
  std::vector<common::Pose2> poses;
  for (const common::Pose3& T : motion.samples()) {
    poses.push_back({T.translation().x(), T.translation().y(), common::rpyFromRotation(T.linear()).yaw});
  }
  return poses;
}

void expectClosedAndFree(const World& world, const Motion& motion, double duration_s) {
  EXPECT_LE(motion.duration(), duration_s);
  EXPECT_GE(smallestClearance(world, fromAbove(motion)), kRobotRadius);
  EXPECT_LT((motion.at(0.9).matrix() - common::Pose3::Identity().matrix()).norm(), 1e-4);
  const common::Pose3 end = motion.at(duration_s);
  EXPECT_LT(end.translation().norm(), 0.05);
  EXPECT_LT(Eigen::AngleAxisd(end.linear()).angle(), 0.05);
  const auto& samples = motion.samples();
  for (std::size_t i = 1; i < samples.size(); ++i) {
    ASSERT_LT((samples[i].translation() - samples[i - 1].translation()).norm(), 0.007);
  }
}

/// A single camera needs some way before the first turn on the spot.
void expectWayBeforeTurns(const Motion& motion) {
  const std::vector<common::Pose2> poses = fromAbove(motion);
  double way = 0.0;
  for (std::size_t i = 1; i < poses.size() && way < 1.0; ++i) {
    const double step = (poses[i].translation() - poses[i - 1].translation()).norm();
    way += step;
    const double turned = std::abs(common::wrapAngle(poses[i].yaw - poses[i - 1].yaw));
    ASSERT_LT(turned, 5.0 * step + 1e-4) << way;
  }
}

TEST(Route, FlatFitsIntoTheShortestMission) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const World world = makeWorld(flat(), seed);
    const Motion motion = planMission(world, MissionKind::kFlat, seed, 20.0, {});
    expectClosedAndFree(world, motion, 20.0);
    expectWayBeforeTurns(motion);
    EXPECT_GT(motion.pathLength(), 2.0);
  }
}

TEST(Route, FlatUsesItsTime) {
  const World world = makeWorld(flat(), 5);
  const Motion motion = planMission(world, MissionKind::kFlat, 5, 75.0, {});
  expectClosedAndFree(world, motion, 75.0);
  EXPECT_GT(motion.duration(), 0.85 * 75.0);
  EXPECT_GT(motion.pathLength(), 15.0);
}

TEST(Route, RescueGoesOverThePlatform) {
  constexpr double kDuration = 160.0;
  for (const std::uint64_t seed : {1, 9}) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const World world = makeWorld(bare(), seed);
    const Motion motion = planMission(world, MissionKind::kRescue, seed, kDuration, {});
    expectClosedAndFree(world, motion, kDuration);
    expectWayBeforeTurns(motion);
    EXPECT_GE(motion.pathLength(), 30.0);
    double highest = 0.0;
    double steep = 0.0;
    const auto& samples = motion.samples();
    for (std::size_t i = 1; i < samples.size(); ++i) {
      const Eigen::Vector3d p = samples[i].translation();
      const double step = (p - samples[i - 1].translation()).norm();
      highest = std::max(highest, p.z());
      for (const Polygon& area : {world.crossing->ramp, world.crossing->stairs}) {
        steep += depthInside(area, p.head<2>()) > 0.0 ? step : 0.0;
      }
    }
    EXPECT_GE(steep, 3.0);
    EXPECT_GE(highest, 1.0);
    EXPECT_LT(highest, world.crossing->height + 0.1);
  }
}

TEST(Route, TourMayCross) {
  const World world = makeWorld(bare(), 2);
  const Motion motion = planMission(world, MissionKind::kTour, 2, 90.0, {});
  expectClosedAndFree(world, motion, 90.0);
  EXPECT_GT(motion.duration(), 0.8 * 90.0);
}

TEST(Route, IsTheSameForTheSameSeedOnly) {
  const World world = makeWorld(flat(), 1);
  const Motion one = planMission(world, MissionKind::kFlat, 1, 30.0, {});
  const Motion again = planMission(world, MissionKind::kFlat, 1, 30.0, {});
  const Motion other = planMission(world, MissionKind::kFlat, 2, 30.0, {});
  ASSERT_EQ(one.samples().size(), again.samples().size());
  for (std::size_t i = 0; i < one.samples().size(); ++i) {
    ASSERT_EQ(one.samples()[i].matrix(), again.samples()[i].matrix());
  }
  EXPECT_NE(one.at(8.0).translation(), other.at(8.0).translation());
}

TEST(Route, TellsHowLongTheMissionTakes) {
  const World world = makeWorld(bare(), 1);
  const auto plan = [&](MissionKind kind, double seconds) {
    return test::errorOf([&] { planMission(world, kind, 1, seconds, {}); });
  };
  EXPECT_NE(plan(MissionKind::kFlat, 3.0).find("does not fit into 3 s"), std::string::npos);
  const std::string error = plan(MissionKind::kRescue, 40.0);
  const std::string before = "it needs at least ";
  const std::size_t at = error.find(before);
  ASSERT_NE(at, std::string::npos) << error;
  EXPECT_EQ(plan(MissionKind::kRescue, std::stod(error.substr(at + before.size()))), "(no error)");
}

TEST(Route, RescueNeedsACrossing) {
  const World world = makeWorld(flat(), 1);
  const std::string error = test::errorOf([&] { planMission(world, MissionKind::kRescue, 1, 200.0, {}); });
  EXPECT_NE(error.find("world.crossing"), std::string::npos) << error;
}

}  // namespace
}  // namespace rubble::arena_sim
