#include "joint/point_scale.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "drive.h"

namespace rubble::fusion {
namespace {

using common::Pose3;
using Eigen::Vector3d;

constexpr std::int32_t kMap = 4;
constexpr double kWall = 3.0;  // m ahead of the body

/// A robot before a wall, in a monocular map of a scale that nobody was told.
class PointScaleTest : public testing::Test {
 protected:
  PointScaleTest() {
    scan_.first_angle = -1.0;
    scan_.angle_step = 0.005;
    const Vector3d lidar = T_world_lidar_.translation();
    for (int i = 0; i <= 400; ++i) {
      const double angle = scan_.first_angle + i * scan_.angle_step;
      scan_.ranges.push_back(static_cast<float>((kWall - lidar.x()) / std::cos(angle)));
    }
  }

  /// Points at this way ahead, all over the wall's height.
  void addPoints(int n, double x, double noise = 0.0) {
    std::uniform_real_distribution<double> side(-1.2, 1.2);
    std::uniform_real_distribution<double> height(0.1, 0.7);
    std::normal_distribution<double> error(0.0, 1.0);
    for (int i = 0; i < n; ++i) {
      const Vector3d p(x + noise * error(random_), side(random_), height(random_));
      points_.set(next_id_++, kMap, S_.R.transpose() * (p - S_.p) / S_.scale);
    }
  }

  std::optional<double> measure(std::optional<double> guess = std::nullopt) const {
    const Pose3 T_world_camera = robot_.T_body_camera();
    return points_.measure(kMap, test::T_mono_camera(T_world_camera, S_),
                           T_world_camera.inverse() * T_world_lidar_, scan_, guess);
  }

  const common::RobotConfig robot_ = test::robot();
  const Similarity S_ = test::S_world_mono();
  const Pose3 T_world_lidar_ = robot_.T_body_lidar();
  RangeScan scan_;
  PointScale points_;

 private:
  std::mt19937 random_{3};
  std::int64_t next_id_ = 0;
};

TEST_F(PointScaleTest, IsKnownWithoutAnyMotion) {
  addPoints(300, kWall, 0.05);
  const auto scale = measure();
  ASSERT_TRUE(scale);
  EXPECT_NEAR(*scale, std::log(S_.scale), 0.01);
}

TEST_F(PointScaleTest, PointsBehindTheWallDoNotCount) {
  addPoints(100, kWall, 0.05);
  for (int i = 0; i < 10; ++i) {
    addPoints(100, kWall + 0.5 + 0.7 * i);
  }
  const auto near = measure(std::log(S_.scale) + 0.05);
  ASSERT_TRUE(near);
  EXPECT_NEAR(*near, std::log(S_.scale), 0.015);
}

TEST_F(PointScaleTest, FewPointsOrNoRangesTellNothing) {
  addPoints(5, kWall);
  EXPECT_FALSE(measure());
  addPoints(300, kWall);
  EXPECT_TRUE(measure());
  scan_.ranges.assign(scan_.ranges.size(), std::numeric_limits<float>::infinity());
  EXPECT_FALSE(measure());
}

TEST_F(PointScaleTest, ErasedPointsAreGone) {
  addPoints(300, kWall);
  for (std::int64_t id = 0; id < 300; ++id) {
    points_.erase(id);
  }
  EXPECT_FALSE(measure());
}

}  // namespace
}  // namespace rubble::fusion
