#include "sensors/odometry_model.h"

#include <gtest/gtest.h>

#include <cmath>

namespace rubble::arena_sim {
namespace {

using common::Pose2;
using common::Pose3;

constexpr double kDuration = 30.0;

/// A circle of 1 m radius at 0.5 m/s.
Pose2 planarAt(double seconds) {
  const double angle = 0.5 * std::max(0.0, seconds);
  return {std::sin(angle), 1.0 - std::cos(angle), common::wrapAngle(angle)};
}
Pose3 circling(double seconds) { return common::pose3FromPose2(planarAt(seconds)); }

/// Straight up a slope of 0.3 rad at 0.5 m/s along it.
Pose3 climbing(double seconds) {
  Pose3 T = Pose3::Identity();
  T.linear() = common::rotationFromRpy({0.0, -0.3, 0.0});
  T.translation() = T.linear() * Eigen::Vector3d(0.5 * seconds, 0.0, 0.0);
  return T;
}

OdometryModelConfig withoutSlip() {
  OdometryModelConfig config;
  config.slip_forward = config.slip_turn = config.slip_slope = config.heading_drift = 0.0;
  return config;
}

TEST(OdometryModel, WithoutSlipItIsTheTruth) {
  const OdometryModelConfig config = withoutSlip();
  OdometryModel odometry(config, circling, std::mt19937_64(1));
  for (int i = 0; i < kDuration * config.rate; ++i) {
    const Pose2 error = planarAt(i / config.rate).inverse() * odometry.next();
    ASSERT_LT(error.translation().norm(), 0.005);
    ASSERT_LT(std::abs(error.yaw), 1e-6);
  }
}

TEST(OdometryModel, CountsTheWayAlongASlopeAndTheTrackLostThere) {
  const auto told = [](const OdometryModelConfig& config) {
    OdometryModel odometry(config, climbing, std::mt19937_64(1));
    Pose2 T_odom_body;
    for (int i = 0; i <= 10.0 * config.rate; ++i) {
      T_odom_body = odometry.next();
    }
    return T_odom_body.x;
  };
  OdometryModelConfig config = withoutSlip();
  EXPECT_NEAR(told(config), 5.0, 1e-6);
  config.slip_slope = 0.2;
  EXPECT_NEAR(told(config), 5.0 * (1.0 + 0.2 * std::sin(0.3)), 1e-6);
}

TEST(OdometryModel, SlipDriftsButDoesNotJump) {
  const OdometryModelConfig config;
  double worst = 0.0;
  double least = 1e9;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    OdometryModel odometry(config, circling, std::mt19937_64(seed));
    Pose2 last;
    Pose2 error;
    for (int i = 0; i < kDuration * config.rate; ++i) {
      const Pose2 now = odometry.next();
      const Pose2 step = last.inverse() * now;
      ASSERT_LT(step.translation().norm(), 0.03);
      ASSERT_LT(std::abs(step.yaw), 0.06);
      error = planarAt(i / config.rate).inverse() * now;
      last = now;
    }
    worst = std::max(worst, error.translation().norm());
    least = std::min(least, error.translation().norm());
  }
  EXPECT_GT(least, 0.001);
  EXPECT_GT(worst, 0.1);
  EXPECT_LT(worst, 3.0);
}

}  // namespace
}  // namespace rubble::arena_sim
