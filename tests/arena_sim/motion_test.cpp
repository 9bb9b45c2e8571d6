#include "motion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace rubble::arena_sim {
namespace {

using common::Pose2;

Motion zigzag(const MotionLimits& limits) {
  Driver driver(limits);
  driver.stand(0.5);
  driver.follow({{0.0, 0.0}, {2.0, 0.5}, {3.0, 2.0}, {0.5, 2.0}});
  driver.stand(0.5);
  driver.follow({{0.5, 2.0}, {0.0, 0.0}});
  driver.turnTo(0.0);
  return driver.motion();
}

TEST(Motion, KeepsItsLimits) {
  const MotionLimits limits;
  const Motion motion = zigzag(limits);
  const auto& samples = motion.samples();
  double last_speed = 0.0;
  double last_rate = 0.0;
  double fastest = 0.0;
  double fastest_turn = 0.0;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    const Pose2& a = samples[i - 1];
    const Pose2& b = samples[i];
    const double speed = std::hypot(b.x - a.x, b.y - a.y) / Motion::kStep;
    const double rate = (b.yaw - a.yaw) / Motion::kStep;
    ASSERT_LE(std::abs(speed - last_speed), limits.acceleration * Motion::kStep + 1e-9);
    ASSERT_LE(std::abs(rate - last_rate), limits.turn_acceleration * Motion::kStep + 1e-9);
    // Tracks roll, they do not shift sideways.
    const double heading = 0.5 * (a.yaw + b.yaw);
    ASSERT_NEAR((b.y - a.y) * std::cos(heading) - (b.x - a.x) * std::sin(heading), 0.0, 1e-12);
    fastest = std::max(fastest, speed);
    fastest_turn = std::max(fastest_turn, std::abs(rate));
    last_speed = speed;
    last_rate = rate;
  }
  EXPECT_LE(fastest, limits.cruise_speed + 1e-9);
  EXPECT_GT(fastest, 0.9 * limits.cruise_speed);
  EXPECT_LE(fastest_turn, limits.turn_rate + 1e-9);
  EXPECT_GT(fastest_turn, 0.9 * limits.turn_rate);
  EXPECT_EQ(last_speed, 0.0);
}

TEST(Motion, FollowsTheWayAndComesBack) {
  const Motion motion = zigzag({});
  const std::vector<Segment> way{
      {{0.0, 0.0}, {2.0, 0.5}}, {{2.0, 0.5}, {3.0, 2.0}}, {{3.0, 2.0}, {0.5, 2.0}}, {{0.5, 2.0}, {0.0, 0.0}}};
  for (const Pose2& pose : motion.samples()) {
    double off = 1e9;
    for (const Segment& piece : way) {
      off = std::min(off, distanceTo(piece, pose.translation()));
    }
    ASSERT_LT(off, 0.11);
  }
  const Pose2 end = motion.at(motion.duration());
  EXPECT_LT(end.translation().norm(), 0.03);
  EXPECT_LT(std::abs(common::wrapAngle(end.yaw)), 0.02);
}

TEST(Motion, GetsAroundHairpins) {
  for (const double width : {0.0, 0.02, 0.1, 0.3, 0.6}) {
    Driver driver({});
    driver.follow({{0.0, 0.0}, {1.0, 0.0}, {0.0, width}, {1.0, 2.0 * width}});
    EXPECT_LT(driver.motion().duration(), 25.0) << width;
    EXPECT_LT((driver.motion().samples().back().translation() - Eigen::Vector2d(1.0, 2.0 * width)).norm(),
              0.04);
  }
}

TEST(Motion, IsLinearBetweenSamplesAndStandsAtItsEnds) {
  const Motion motion = zigzag({});
  const auto& samples = motion.samples();
  const Pose2 middle = motion.at(100.5 * Motion::kStep);
  EXPECT_NEAR(middle.x, 0.5 * (samples[100].x + samples[101].x), 1e-12);
  EXPECT_NEAR(middle.yaw, 0.5 * (samples[100].yaw + samples[101].yaw), 1e-12);
  EXPECT_EQ(motion.at(-1.0).x, samples.front().x);
  EXPECT_EQ(motion.at(1e6).yaw, samples.back().yaw);
}

}  // namespace
}  // namespace rubble::arena_sim
