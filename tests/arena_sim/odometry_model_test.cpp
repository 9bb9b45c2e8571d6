#include "odometry_model.h"

#include <gtest/gtest.h>

#include <cmath>

namespace rubble::arena_sim {
namespace {

using common::Pose2;

Motion square() {
  Driver driver({});
  driver.follow({{0.0, 0.0}, {3.0, 0.0}, {3.0, 3.0}, {0.0, 3.0}, {0.0, 0.0}});
  return driver.motion();
}

TEST(OdometryModel, WithoutSlipItIsTheTruth) {
  const Motion motion = square();
  OdometryModelConfig config;
  config.slip_forward = config.slip_turn = config.heading_drift = 0.0;
  OdometryModel odometry(config, motion, 1);
  for (double t = 0.0; t < motion.duration(); t += 1.0 / config.rate) {
    const Pose2 error = motion.at(t).inverse() * odometry.next();
    ASSERT_LT(error.translation().norm(), 0.005);
    ASSERT_LT(std::abs(error.yaw), 1e-6);
  }
}

TEST(OdometryModel, SlipDriftsButDoesNotJump) {
  const Motion motion = square();
  const OdometryModelConfig config;
  double worst = 0.0;
  double least = 1e9;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    OdometryModel odometry(config, motion, seed);
    Pose2 last;
    Pose2 error;
    for (double t = 0.0; t < motion.duration(); t += 1.0 / config.rate) {
      const Pose2 now = odometry.next();
      const Pose2 step = last.inverse() * now;
      ASSERT_LT(step.translation().norm(), 0.03);
      ASSERT_LT(std::abs(step.yaw), 0.06);
      error = motion.at(t).inverse() * now;
      last = now;
    }
    worst = std::max(worst, error.translation().norm());
    least = std::min(least, error.translation().norm());
  }
  EXPECT_GT(least, 0.001);
  EXPECT_GT(worst, 0.2);
  EXPECT_LT(worst, 3.0);
}

}  // namespace
}  // namespace rubble::arena_sim
