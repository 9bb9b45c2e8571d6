#include "alignment.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "drive.h"
#include "mount_check.h"

namespace rubble::fusion {
namespace {

using common::Pose3;
using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Samples along a path, `T_world_body(i)`; noise of the LiDAR in m.
template <typename Path>
std::vector<AlignmentSample> samples(int n, const Path& T_world_body, double noise = 0.0,
                                     const Similarity& S = test::S_world_mono()) {
  std::mt19937 random(7);
  std::normal_distribution<double> error(0.0, noise);
  const common::RobotConfig robot = test::robot();
  std::vector<AlignmentSample> result;
  for (int i = 0; i < n; ++i) {
    const Pose3 T_body = T_world_body(i);
    const Pose3 T_body_lidar = robot.T_body_plate(0.05 * std::sin(i), 0.0) * robot.lidar.pose();
    AlignmentSample sample;
    sample.T_mono_camera = test::T_mono_camera(T_body * robot.T_body_camera(), S);
    sample.T_camera_lidar = robot.T_body_camera().inverse() * T_body_lidar;
    sample.T_world_lidar = test::level(T_body * T_body_lidar);
    sample.T_world_lidar.x += error(random);
    sample.T_world_lidar.y += error(random);
    result.push_back(sample);
  }
  return result;
}

Pose3 winding(int i) { return test::windingPath(0.05 * i); }

/// A prior that is off in everything.
Similarity roughPrior() {
  Similarity S = test::S_world_mono();
  S.R = Eigen::AngleAxisd(0.03, Vector3d(1.0, 1.0, 5.0).normalized()).toRotationMatrix() * S.R;
  S.scale *= 1.1;
  S.p += Vector3d(0.1, -0.1, 0.05);
  return S;
}

const Pose3 kCameraBody = test::robot().T_body_camera().inverse();

TEST(Alignment, JacobianIsTheNumericOne) {
  const auto all = samples(12, [](int i) { return test::pitchedUp(winding(8 * i), 0.3); });
  const Similarity S = roughPrior();
  for (const AlignmentSample& sample : all) {
    SampleJacobian J;
    alignmentResidual(sample, kCameraBody, S, &J);
    for (int k = 0; k < 7; ++k) {
      constexpr double kStep = 1e-6;
      Eigen::Matrix<double, 7, 1> delta = Eigen::Matrix<double, 7, 1>::Zero();
      delta(k) = kStep;
      const SampleResidual numeric = (alignmentResidual(sample, kCameraBody, perturbed(S, delta)) -
                                      alignmentResidual(sample, kCameraBody, perturbed(S, -delta))) /
                                     (2.0 * kStep);
      EXPECT_LT((numeric - J.col(k)).norm(), 1e-6) << "parameter " << k;
    }
  }
}

TEST(Alignment, FindsTheSimilarity) {
  const Similarity truth = test::S_world_mono();
  AlignmentConfig config;
  config.tilt_sigma = 0.01;  // The rough prior's attitude is off by about that.
  const auto alignment = align(samples(100, winding), kCameraBody, roughPrior(), false, config);
  ASSERT_TRUE(alignment);
  EXPECT_NEAR(alignment->S_world_mono.scale / truth.scale, 1.0, 1e-3);
  EXPECT_LT(test::angleBetween(alignment->S_world_mono.R, truth.R), 2e-3);
  EXPECT_LT((alignment->S_world_mono.p - truth.p).norm(), 5e-3);
  EXPECT_LT(alignment->scaleSigma(), 0.01);
}

TEST(Alignment, StandsNoiseAndRampsUnderTheRobot) {
  const Similarity truth = test::S_world_mono();
  const auto hilly = [](int i) {  // A quarter of the way leads over a field of ramps.
    Pose3 T = winding(i);
    if (i >= 40 && i < 70) {
      T.translation().z() += 0.12;
      T = test::pitchedUp(T, i % 2 == 0 ? 0.2 : -0.2);
    }
    return T;
  };
  const auto alignment = align(samples(120, hilly, 0.02), kCameraBody, roughPrior(), false, {});
  ASSERT_TRUE(alignment);
  EXPECT_NEAR(alignment->S_world_mono.scale / truth.scale, 1.0, 0.01);
  EXPECT_LT(test::angleBetween(alignment->S_world_mono.R, truth.R), 0.015);
}

TEST(Alignment, KeepsWhatTheMotionDoesNotShow) {
  Similarity prior = test::S_world_mono();
  prior.scale *= 1.05;
  const auto standing = align(samples(
                                  50, [](int) { return winding(10); }, 0.005),
                              kCameraBody, prior, true, {});
  ASSERT_TRUE(standing);
  EXPECT_NEAR(standing->S_world_mono.scale / prior.scale, 1.0, 0.01);
  const auto unknown = align(samples(
                                 50, [](int) { return winding(10); }, 0.005),
                             kCameraBody, prior, false, {});
  ASSERT_TRUE(unknown);
  EXPECT_GT(unknown->scaleSigma(), 0.1) << "standing still shows no scale";

  // A pure turn moves the camera on a small circle only: nothing blows up.
  const auto turning = align(samples(
                                 50,
                                 [](int i) {
                                   return common::pose3FromPose2({1.0, 2.0, 0.1 * i});
                                 },
                                 0.005),
                             kCameraBody, prior, true, {});
  ASSERT_TRUE(turning);
  EXPECT_NEAR(turning->S_world_mono.scale / prior.scale, 1.0, 0.06);

  // A straight line shows scale and heading, not the roll about it.
  const auto straight = align(samples(50,
                                      [](int i) {
                                        return common::pose3FromPose2({0.05 * i, 0.0, 0.0});
                                      }),
                              kCameraBody, roughPrior(), false, {});
  ASSERT_TRUE(straight);
  EXPECT_NEAR(straight->S_world_mono.scale / test::S_world_mono().scale, 1.0, 5e-3);
}

TEST(Alignment, RoughOneNeedsMotion) {
  const Matrix3d R = test::S_world_mono().R;
  EXPECT_FALSE(roughAlignment({}, kCameraBody, R, 0.3));
  EXPECT_FALSE(roughAlignment(samples(5, winding), kCameraBody, R, 0.3));
  const auto rough = roughAlignment(samples(30, winding), kCameraBody, R, 0.3);
  ASSERT_TRUE(rough);
  EXPECT_NEAR(rough->scale / test::S_world_mono().scale, 1.0, 0.02);
  EXPECT_LT((rough->p - test::S_world_mono().p).norm(), 0.02);
}

TEST(MountCheck, FindsErrorsAndNoOthers) {
  const common::RobotConfig robot = test::robot();
  const auto wander = [](int i) { return test::windingPath(0.1 * i); };
  const auto judge = [&](const Pose3& T_body_camera_believed, double clock) {
    auto seen = samples(150, wander, 0.01);
    for (std::size_t i = 0; i < seen.size(); ++i) {
      const Pose3 T_body_lidar = robot.T_body_camera() * seen[i].T_camera_lidar;
      seen[i].T_camera_lidar = T_body_camera_believed.inverse() * T_body_lidar;
      const Pose3 before = wander(static_cast<int>(i)) * T_body_lidar;
      const Pose3 after = wander(static_cast<int>(i) + 1) * T_body_lidar;
      const double dt = 0.2;
      seen[i].v_world_lidar = {(after.translation().x() - before.translation().x()) / dt,
                               (after.translation().y() - before.translation().y()) / dt,
                               common::wrapAngle(test::level(after).yaw - test::level(before).yaw) / dt};
      seen[i].T_world_lidar.x -= clock * seen[i].v_world_lidar.x();
      seen[i].T_world_lidar.y -= clock * seen[i].v_world_lidar.y();
      seen[i].T_world_lidar.yaw -= clock * seen[i].v_world_lidar.z();
    }
    MountCheck check(T_body_camera_believed);
    const auto alignment = align(seen, T_body_camera_believed.inverse(), test::S_world_mono(), false, {});
    check.addWindow(seen, alignment->S_world_mono, {});
    EXPECT_EQ(check.complaint(), "") << "one window is not enough";
    check.addWindow(seen, alignment->S_world_mono, {});
    return check.complaint();
  };
  EXPECT_EQ(judge(robot.T_body_camera(), 0.0), "");
  Pose3 turned = robot.T_body_camera();
  turned.linear() = common::rotationFromRpy({0.0, 0.0, 0.035}) * turned.linear();
  EXPECT_NE(judge(turned, 0.0).find("the camera's yaw by -"), std::string::npos) << judge(turned, 0.0);
  Pose3 moved = robot.T_body_camera();
  moved.translation().y() += 0.05;
  EXPECT_NE(judge(moved, 0.0).find("from LiDAR to camera along y by -5 cm"), std::string::npos)
      << judge(moved, 0.0);
  EXPECT_NE(judge(robot.T_body_camera(), 0.1).find("clocks of camera and LiDAR differ by about"),
            std::string::npos)
      << judge(robot.T_body_camera(), 0.1);
}

TEST(Alignment, AxisScaleIsTheRegressionOfEquation8) {
  // Level map, LiDAR over the camera: then both axes show the scale itself.
  Similarity S;
  S.scale = 1.8;
  std::vector<AlignmentSample> all;
  for (int i = 0; i < 40; ++i) {
    AlignmentSample sample;
    sample.T_world_lidar = {0.1 * i, std::sin(0.3 * i), 0.0};
    sample.T_mono_camera = common::pose3FromPose2(
        {(sample.T_world_lidar.x - 0.4) / S.scale, (sample.T_world_lidar.y + 0.2) / S.scale, 0.0});
    sample.T_camera_lidar = Pose3::Identity();
    all.push_back(sample);
  }
  const auto scale = axisScale(all, Matrix3d::Identity());
  ASSERT_TRUE(scale);
  EXPECT_NEAR(*scale, S.scale, 1e-9);
  for (AlignmentSample& sample : all) {
    sample.T_world_lidar = {1.0, 2.0, 0.0};
  }
  EXPECT_FALSE(axisScale(all, Matrix3d::Identity())) << "standing still";
}

}  // namespace
}  // namespace rubble::fusion
