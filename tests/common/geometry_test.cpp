#include "common/geometry.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace rubble::common {
namespace {

constexpr double kPi = std::numbers::pi;

Eigen::Isometry2d isometry(const Pose2& T) {
  Eigen::Isometry2d out = Eigen::Isometry2d::Identity();
  out.linear() = Eigen::Rotation2Dd(T.yaw).toRotationMatrix();
  out.translation() = T.translation();
  return out;
}

void expectNear(const Pose2& a, const Pose2& b, double tolerance = 1e-12) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(wrapAngle(a.yaw - b.yaw), 0.0, tolerance);
}

class RandomPoses : public testing::Test {
 protected:
  Pose2 next() { return {metres_(generator_), metres_(generator_), angle_(generator_)}; }

  std::mt19937 generator_{7};
  std::uniform_real_distribution<double> metres_{-20.0, 20.0};
  std::uniform_real_distribution<double> angle_{-9.0, 9.0};
};

using Pose2Test = RandomPoses;

TEST(WrapAngle, FoldsIntoHalfOpenInterval) {
  EXPECT_DOUBLE_EQ(wrapAngle(0.0), 0.0);
  EXPECT_DOUBLE_EQ(wrapAngle(kPi), kPi);
  EXPECT_DOUBLE_EQ(wrapAngle(-kPi), kPi) << "-pi is not in (-pi, pi]";
  EXPECT_DOUBLE_EQ(wrapAngle(3.0 * kPi), kPi);
  EXPECT_NEAR(wrapAngle(2.0 * kPi + 0.25), 0.25, 1e-15);
  EXPECT_NEAR(wrapAngle(-2.0 * kPi - 0.25), -0.25, 1e-15);
  EXPECT_TRUE(std::isnan(wrapAngle(std::nan(""))));
}

TEST(WrapAngle, StaysInIntervalAndKeepsTheDirection) {
  for (double angle = -50.0; angle < 50.0; angle += 0.0137) {
    const double wrapped = wrapAngle(angle);
    EXPECT_GT(wrapped, -kPi);
    EXPECT_LE(wrapped, kPi);
    EXPECT_NEAR(std::cos(wrapped), std::cos(angle), 1e-12);
    EXPECT_NEAR(std::sin(wrapped), std::sin(angle), 1e-12);
  }
}

TEST_F(Pose2Test, InverseUndoes) {
  for (int i = 0; i < 200; ++i) {
    const Pose2 T = next();
    expectNear(T * T.inverse(), {});
    expectNear(T.inverse() * T, {});
  }
}

TEST_F(Pose2Test, IsAssociative) {
  for (int i = 0; i < 200; ++i) {
    const Pose2 a = next();
    const Pose2 b = next();
    const Pose2 c = next();
    expectNear((a * b) * c, a * (b * c));
  }
}

TEST_F(Pose2Test, AgreesWithEigen) {
  for (int i = 0; i < 200; ++i) {
    const Pose2 a = next();
    const Pose2 b = next();
    const Eigen::Vector2d p(1.5, -0.5);
    EXPECT_TRUE(isometry(a * b).isApprox(isometry(a) * isometry(b), 1e-12));
    EXPECT_TRUE(isometry(a.inverse()).isApprox(isometry(a).inverse(), 1e-12));
    EXPECT_TRUE((a * p).isApprox(isometry(a) * p, 1e-12));
  }
}

TEST_F(Pose2Test, LiftsToALevelPose3) {
  const Pose2 T{1.0, -2.0, 0.7};
  const Pose3 lifted = pose3FromPose2(T, 0.3);
  EXPECT_TRUE(
      (lifted * Eigen::Vector3d(2.0, 1.0, 0.0)).head<2>().isApprox(T * Eigen::Vector2d(2.0, 1.0), 1e-12));
  EXPECT_DOUBLE_EQ(lifted.translation().z(), 0.3);
  EXPECT_TRUE((lifted.linear() * Eigen::Vector3d::UnitZ()).isApprox(Eigen::Vector3d::UnitZ()));
}

TEST(RollPitchYaw, IsYawThenPitchThenRoll) {
  const auto R = [](double roll, double pitch, double yaw) { return rotationFromRpy({roll, pitch, yaw}); };
  EXPECT_TRUE(R(0.1, 0.2, 0.3).isApprox(R(0, 0, 0.3) * R(0, 0.2, 0) * R(0.1, 0, 0), 1e-12));
  // Positive pitch lowers the nose, positive roll lifts the left side, positive yaw turns left.
  EXPECT_LT((R(0, 0.1, 0) * Eigen::Vector3d::UnitX()).z(), 0.0);
  EXPECT_GT((R(0.1, 0, 0) * Eigen::Vector3d::UnitY()).z(), 0.0);
  EXPECT_GT((R(0, 0, 0.1) * Eigen::Vector3d::UnitX()).y(), 0.0);
}

TEST(RollPitchYaw, RoundTrips) {
  for (double roll = -3.1; roll < 3.14; roll += 0.31) {
    for (double pitch = -1.5; pitch < 1.57; pitch += 0.25) {
      for (double yaw = -3.1; yaw < 3.14; yaw += 0.31) {
        const RollPitchYaw rpy = rpyFromRotation(rotationFromRpy({roll, pitch, yaw}));
        EXPECT_NEAR(rpy.roll, roll, 1e-9);
        EXPECT_NEAR(rpy.pitch, pitch, 1e-9);
        EXPECT_NEAR(rpy.yaw, yaw, 1e-9);
      }
    }
  }
}

TEST(RollPitchYaw, KeepsTheRotationAtThePole) {
  for (const double pitch : {kPi / 2, -kPi / 2}) {
    for (double roll = -3.0; roll < 3.1; roll += 0.5) {
      for (double yaw = -3.0; yaw < 3.1; yaw += 0.5) {
        const Eigen::Matrix3d R = rotationFromRpy({roll, pitch, yaw});
        const RollPitchYaw rpy = rpyFromRotation(R);
        EXPECT_DOUBLE_EQ(rpy.yaw, 0.0);
        EXPECT_NEAR(rpy.pitch, pitch, 1e-9);
        EXPECT_TRUE(rotationFromRpy(rpy).isApprox(R, 1e-9)) << roll << " " << pitch << " " << yaw;
      }
    }
  }
}

}  // namespace
}  // namespace rubble::common
