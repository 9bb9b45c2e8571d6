#include "route.h"

#include <gtest/gtest.h>

#include "support/error_text.h"

namespace rubble::arena_sim {
namespace {

void expectValid(std::uint64_t seed, double duration_s) {
  const Arena arena = makeArena(seed);
  const Motion motion = planRoute(arena, seed, duration_s, {});
  SCOPED_TRACE(testing::Message() << "seed " << seed << ", " << duration_s << " s");
  EXPECT_GE(arena.rooms.size(), 6U);
  EXPECT_LE(motion.duration(), duration_s);
  EXPECT_GE(smallestClearance(arena, motion), kRobotRadius);
  const common::Pose2 start = motion.at(0.0);
  EXPECT_EQ(start.x, 0.0);
  EXPECT_EQ(start.y, 0.0);
  EXPECT_EQ(start.yaw, 0.0);
  const common::Pose2 end = motion.at(duration_s);
  EXPECT_LT(end.translation().norm(), 0.05);
  EXPECT_LT(std::abs(common::wrapAngle(end.yaw)), 0.03);
  double way = 0.0;
  for (std::size_t i = 1; i < motion.samples().size(); ++i) {
    way += (motion.samples()[i].translation() - motion.samples()[i - 1].translation()).norm();
  }
  EXPECT_GT(way, duration_s >= 75.0 ? 15.0 : 1.0);
  if (duration_s >= 75.0) {
    EXPECT_GT(motion.duration(), 0.85 * duration_s);
  }
}

TEST(Route, IsFreeAndClosedForManySeeds) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    expectValid(seed, 75.0);
  }
}

TEST(Route, FitsIntoTheShortestMission) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    expectValid(seed, 20.0);
  }
}

TEST(Route, SeedsDiffer) {
  const Arena one = makeArena(1);
  const Arena again = makeArena(1);
  const Arena two = makeArena(2);
  ASSERT_EQ(one.segments.size(), again.segments.size());
  for (std::size_t i = 0; i < one.segments.size(); ++i) {
    EXPECT_EQ(one.segments[i].a, again.segments[i].a);
  }
  EXPECT_NE(one.segments.front().a, two.segments.front().a);
}

TEST(Route, TellsWhenNothingFits) {
  const std::string error = test::errorOf([] { planRoute(makeArena(1), 1, 3.0, {}); });
  EXPECT_NE(error.find("no round trip"), std::string::npos) << error;
}

}  // namespace
}  // namespace rubble::arena_sim
