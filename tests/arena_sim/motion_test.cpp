#include "motion/motion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "motion/driver.h"
#include "motion/retrace.h"

namespace rubble::arena_sim {
namespace {

using common::Pose2;

MotionConfig withoutSlip() {
  MotionConfig config;
  config.slip = 0.0;
  return config;
}

std::vector<Pose2> zigzag(const MotionConfig& config) {
  Driver driver(config, {}, 1);
  driver.stand(0.5);
  driver.follow({{0.0, 0.0}, {2.0, 0.5}, {3.0, 2.0}, {0.5, 2.0}}, config.cruise_speed);
  driver.stand(0.5);
  driver.follow({{0.5, 2.0}, {0.0, 0.0}}, config.cruise_speed);
  driver.turnTo(0.0);
  return driver.poses();
}

TEST(Driver, KeepsItsLimits) {
  const MotionConfig config = withoutSlip();
  const std::vector<Pose2> poses = zigzag(config);
  double last_speed = 0.0;
  double last_rate = 0.0;
  double fastest = 0.0;
  double fastest_turn = 0.0;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const Pose2& a = poses[i - 1];
    const Pose2& b = poses[i];
    const double speed = std::hypot(b.x - a.x, b.y - a.y) / Motion::kStep;
    const double rate = (b.yaw - a.yaw) / Motion::kStep;
    ASSERT_LE(std::abs(speed - last_speed), config.acceleration * Motion::kStep + 1e-9);
    ASSERT_LE(std::abs(rate - last_rate), config.turn_acceleration * Motion::kStep + 1e-9);
    // Tracks roll, they do not shift sideways.
    const double heading = 0.5 * (a.yaw + b.yaw);
    ASSERT_NEAR((b.y - a.y) * std::cos(heading) - (b.x - a.x) * std::sin(heading), 0.0, 1e-12);
    fastest = std::max(fastest, speed);
    fastest_turn = std::max(fastest_turn, std::abs(rate));
    last_speed = speed;
    last_rate = rate;
  }
  EXPECT_LE(fastest, config.cruise_speed + 1e-9);
  EXPECT_GT(fastest, 0.9 * config.cruise_speed);
  EXPECT_LE(fastest_turn, config.turn_rate + 1e-9);
  EXPECT_GT(fastest_turn, 0.9 * config.turn_rate);
  EXPECT_EQ(last_speed, 0.0);
  EXPECT_EQ(last_rate, 0.0);
}

TEST(Driver, FollowsTheWayAndComesBackThoughItSlips) {
  const std::vector<Segment> way{
      {{0.0, 0.0}, {2.0, 0.5}}, {{2.0, 0.5}, {3.0, 2.0}}, {{3.0, 2.0}, {0.5, 2.0}}, {{0.5, 2.0}, {0.0, 0.0}}};
  for (const double slip : {0.0, 0.05, 0.1}) {
    MotionConfig config;
    config.slip = slip;
    const std::vector<Pose2> poses = zigzag(config);
    for (const Pose2& pose : poses) {
      double off = 1e9;
      for (const Segment& piece : way) {
        off = std::min(off, distanceTo(piece, pose.translation()));
      }
      ASSERT_LT(off, 0.12);
    }
    EXPECT_LT(poses.back().translation().norm(), 0.03);
    EXPECT_LT(std::abs(common::wrapAngle(poses.back().yaw)), 0.03);
  }
}

TEST(Driver, SlipsOnlyWhenToldTo) {
  const std::vector<Pose2> firm = zigzag(withoutSlip());
  const std::vector<Pose2> slipping = zigzag({});
  EXPECT_NE(firm.size(), slipping.size());
}

TEST(Driver, IsSlowWhereTheGroundIsSteep) {
  const Polygon area{{2.0, -1.0}, {4.0, -1.0}, {4.0, 1.0}, {2.0, 1.0}};
  Driver driver(withoutSlip(), {SlowZone(area, 0.2, 0.6, 1.0)}, 1);
  driver.follow({{0.0, 0.0}, {6.0, 0.0}}, 0.5);
  const auto& poses = driver.poses();
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const double speed = (poses[i].x - poses[i - 1].x) / Motion::kStep;
    if (poses[i].x > 2.1 && poses[i].x < 3.9) {
      ASSERT_LT(speed, 0.21);
    }
    if (poses[i].x > 2.5 && poses[i].x < 3.9) {
      ASSERT_NEAR(speed, 0.2 * std::cos(0.6), 1e-6);
    }
  }
}

TEST(Driver, GetsAroundHairpins) {
  for (const double width : {0.0, 0.02, 0.1, 0.3, 0.6}) {
    Driver driver({}, {}, 1);
    driver.follow({{0.0, 0.0}, {1.0, 0.0}, {0.0, width}, {1.0, 2.0 * width}}, 0.5);
    EXPECT_LT(driver.seconds(), 40.0) << width;
    EXPECT_LT((driver.pose().translation() - Eigen::Vector2d(1.0, 2.0 * width)).norm(), 0.04);
  }
}

TEST(Motion, IsLinearBetweenSamplesAndStandsAtItsEnds) {
  common::Pose3 a = common::pose3FromPose2({1.0, 2.0, 0.0}, 0.5);
  common::Pose3 b = common::pose3FromPose2({1.0, 2.0, 0.2}, 0.7);
  const Motion motion({a, b, b});
  EXPECT_DOUBLE_EQ(motion.duration(), 2.0 * Motion::kStep);
  EXPECT_NEAR(motion.pathLength(), 0.2, 1e-12);
  const common::Pose3 middle = motion.at(0.25 * Motion::kStep);
  EXPECT_NEAR(middle.translation().z(), 0.55, 1e-12);
  EXPECT_NEAR(common::rpyFromRotation(middle.linear()).yaw, 0.05, 1e-12);
  EXPECT_EQ(motion.at(-1.0).translation(), a.translation());
  EXPECT_EQ(motion.at(1e6).translation(), b.translation());
}

TEST(Retrace, BacksUpAlongTheWayAndDrivesOnAsPlanned) {
  std::vector<common::Pose3> samples;
  for (const Pose2& pose : zigzag(withoutSlip())) {
    samples.push_back(common::pose3FromPose2(pose));
  }
  const Motion plan(samples);
  constexpr double kFrom = 8.0;
  constexpr double kTo = 5.0;
  const auto [motion, end] = retrace(plan, kFrom, kTo);
  const auto apart = [](const common::Pose3& a, const common::Pose3& b) {
    return (a.translation() - b.translation()).norm() +
           Eigen::AngleAxisd(a.linear().transpose() * b.linear()).angle();
  };
  EXPECT_EQ(motion.samples().size(), samples.size());
  EXPECT_EQ(apart(motion.at(kFrom), plan.at(kFrom)), 0.0);
  EXPECT_LT(apart(motion.at(end), plan.at(kTo)), 0.01);
  // A second to turn round, and a quarter longer than at full pace to stop.
  EXPECT_NEAR(end, kFrom + (kFrom - kTo) + 1.25, 0.02);
  const double back_at = end + (kFrom - kTo) + 0.25;
  EXPECT_LT(apart(motion.at(back_at), plan.at(kFrom)), 0.01);
  EXPECT_LT(apart(motion.at(back_at + 1.0), plan.at(kFrom + 1.0)), 0.01);
}

TEST(Retrace, AMissionThatEndsOnTheWayBackEndsThere) {
  const Motion plan(std::vector<common::Pose3>(1000, common::Pose3::Identity()));
  const auto [motion, end] = retrace(plan, 4.0, 0.5);
  EXPECT_EQ(motion.duration(), plan.duration());
  EXPECT_EQ(end, plan.duration());
}

}  // namespace
}  // namespace rubble::arena_sim
