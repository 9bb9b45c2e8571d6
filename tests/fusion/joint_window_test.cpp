#include "joint/joint_window.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "drive.h"

namespace rubble::fusion {
namespace {

using common::Pose3;
using Eigen::Vector3d;

const Pose3 kCameraBody = test::robot().T_body_camera().inverse();
const Pose3 kCameraLidar = kCameraBody * test::robot().T_body_lidar();
constexpr double kStep = 0.1;   // m between states
constexpr double kSpeed = 0.5;  // m/s

/// A drive with vision whose scale is wrong by a factor, and a LiDAR.
struct Drive {
  double scale_error = 0.0;   // logarithm
  double motion_noise = 0.0;  // m per step
  double turn_noise = 0.0;    // rad per step
  double lidar_noise = 0.0;   // m
  double lidar_late = 0.0;    // s that the LiDAR's stamps are behind
  double rise = 0.0;          // rad, of the ground
  bool floor = false;
  int lidar_until = 1 << 20;
  std::uint32_t seed = 1;

  Pose3 T_world_camera(double way) const {
    Pose3 T = test::pitchedUp(test::windingPath(way), rise);
    T.translation().z() += std::sin(rise) * way;
    return T * kCameraBody.inverse();
  }

  JointEstimate run(JointWindow& window, int steps) const {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    const auto noise = [&](double sigma) -> Vector3d {
      return Vector3d(normal(random), normal(random), normal(random)) * sigma;
    };
    JointVector sigmas;
    sigmas << 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.2, 0.02;
    JointState start;
    start.T_world_camera = T_world_camera(0.0);
    window.restart(start, sigmas);
    JointEstimate estimate = window.solve();
    for (int i = 1; i <= steps; ++i) {
      const Pose3 T_now = T_world_camera(kStep * i);
      Pose3 motion = T_world_camera(kStep * (i - 1)).inverse() * T_now;
      motion.translation() = std::exp(-scale_error) * motion.translation() + noise(motion_noise);
      motion.linear() = rotationFromVector(noise(turn_noise)) * motion.linear();
      JointMeasurements measured;
      if (i <= lidar_until) {
        LidarFix fix;
        fix.T_camera_lidar = kCameraLidar;
        fix.T_world_lidar = test::level(T_world_camera(kStep * i + kSpeed * lidar_late) * kCameraLidar);
        const Vector3d error = noise(lidar_noise);
        fix.T_world_lidar.x += error.x();
        fix.T_world_lidar.y += error.y();
        const double ahead = 0.02;  // m; windingPath goes in steps
        const common::Pose2 next = test::level(T_world_camera(kStep * i + ahead) * kCameraLidar);
        const common::Pose2 here = test::level(T_now * kCameraLidar);
        fix.velocity = Vector3d(next.x - here.x, next.y - here.y, common::wrapAngle(next.yaw - here.yaw)) *
                       (kSpeed / ahead);
        fix.covariance = 1e-6 * Eigen::Matrix3d::Identity();
        measured.lidar = fix;
      }
      measured.floor = floor ? std::optional(0.0) : std::nullopt;
      window.add({motion, 0.0}, measured);
      if (i % 5 == 0) {
        estimate = window.solve();
      }
    }
    return estimate;
  }
};

TEST(JointWindow, LearnsTheScaleFromTheLidar) {
  Drive drive;
  drive.scale_error = 0.1;
  drive.lidar_noise = 0.005;
  JointWindow window({}, kCameraBody);
  const JointEstimate half_a_metre = drive.run(window, 5);
  EXPECT_NEAR(half_a_metre.state.log_scale, 0.1, 0.06);
  const JointEstimate estimate = drive.run(window, 50);
  EXPECT_NEAR(estimate.state.log_scale, 0.1, 0.01);
  EXPECT_LT(std::sqrt(estimate.covariance(6, 6)), 0.02);
  EXPECT_LT((estimate.state.T_world_camera.translation() - drive.T_world_camera(5.0).translation())
                .head<2>()
                .norm(),
            0.02);
}

TEST(JointWindow, WhatLeavesTheWindowIsNotForgotten) {
  Drive drive;
  drive.scale_error = 0.1;
  drive.lidar_noise = 0.01;
  drive.motion_noise = 0.002;
  drive.lidar_until = 40;
  JointConfig all, few;
  all.window = 200;
  few.window = 4;
  JointWindow batch(all, kCameraBody), sliding(few, kCameraBody);
  const JointEstimate a = drive.run(batch, 60);
  const JointEstimate b = drive.run(sliding, 60);
  EXPECT_NEAR(a.state.log_scale, b.state.log_scale, 0.002);
  EXPECT_LT((a.state.T_world_camera.translation() - b.state.T_world_camera.translation()).norm(), 0.01);
  EXPECT_NEAR(std::sqrt(a.covariance(6, 6)), std::sqrt(b.covariance(6, 6)), 0.002);
}

TEST(JointWindow, CovarianceCoversTheErrors) {
  JointConfig config;
  config.window = 8;
  Drive drive;
  drive.motion_noise = 1e-3 + config.motion_position * std::sqrt(kStep);
  drive.turn_noise = config.motion_rotation * std::sqrt(kStep);
  drive.lidar_noise = config.lidar_position;
  for (const int lidar_until : {60, 30}) {
    drive.lidar_until = lidar_until;
    int inside = 0;
    constexpr int kRuns = 40;
    for (int run = 0; run < kRuns; ++run) {
      drive.seed = static_cast<std::uint32_t>(run + 1);
      JointWindow window(config, kCameraBody);
      const JointEstimate estimate = drive.run(window, 60);
      const Eigen::Vector2d error =
          (estimate.state.T_world_camera.translation() - drive.T_world_camera(6.0).translation()).head<2>();
      const Eigen::Matrix2d P = estimate.covariance.topLeftCorner<2, 2>();
      inside += error.dot(P.inverse() * error) < 5.99 ? 1 : 0;  // 95 % of a plane's normal distribution
    }
    EXPECT_GE(inside, 34) << lidar_until;
  }
}

TEST(JointWindow, FindsTheClocksApart) {
  Drive drive;
  drive.lidar_late = 0.03;
  drive.lidar_noise = 0.002;
  JointConfig config;
  config.lidar_position = 0.004;
  JointWindow window(config, kCameraBody);
  EXPECT_NEAR(drive.run(window, 80).state.clock, 0.03, 0.01);
}

TEST(JointWindow, FloorHoldsTheTiltButARampIsNoFloor) {
  const auto tiltOf = [](const JointEstimate& e) {
    return std::acos((e.state.T_world_camera.linear() * kCameraBody.linear())(2, 2));
  };
  Drive drive;
  drive.turn_noise = 0.002;
  JointConfig config;
  config.motion_rotation = drive.turn_noise / std::sqrt(kStep);
  JointWindow window(config, kCameraBody);
  double held = 0.0;
  double loose = 0.0;
  for (std::uint32_t seed = 1; seed <= 10; ++seed) {
    drive.seed = seed;
    drive.floor = true;
    held += tiltOf(drive.run(window, 100));
    drive.floor = false;
    loose += tiltOf(drive.run(window, 100));
  }
  EXPECT_LT(held, 0.6 * loose);
  drive.floor = true;
  drive.turn_noise = 0.0;
  drive.rise = 0.2;
  EXPECT_NEAR(tiltOf(drive.run(window, 20)), 0.2, 0.03);
}

}  // namespace
}  // namespace rubble::fusion
