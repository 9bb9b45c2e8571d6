#include "sensors/lens.h"

#include <gmock/gmock.h>

#include <opencv2/calib3d.hpp>
#include <random>
#include <vector>

#include "support/error_text.h"

namespace rubble::arena_sim {
namespace {

using common::RobotConfig;
using ::testing::AllOf;
using ::testing::HasSubstr;

RobotConfig::Intrinsics makeIntrinsics(const char* model, std::vector<double> distortion) {
  RobotConfig::Intrinsics intrinsics;
  intrinsics.model = model;
  intrinsics.focal = {371.5, 368.25};
  intrinsics.centre = {322.75, 236.5};
  intrinsics.distortion = std::move(distortion);
  return intrinsics;
}

std::vector<RobotConfig::Intrinsics> manyIntrinsics() {
  return {makeIntrinsics("pinhole", {0.0, 0.0, 0.0, 0.0}),
          makeIntrinsics("pinhole", {-0.283, 0.074, 0.0007, -0.0004}),
          makeIntrinsics("pinhole", {0.12, -0.01, -0.002, 0.003}),
          makeIntrinsics("fisheye", {0.0, 0.0, 0.0, 0.0}),
          makeIntrinsics("fisheye", {-0.013, 0.021, -0.0139, 0.0036})};
}

cv::Point2d projectByOpenCv(const RobotConfig::Intrinsics& intrinsics, const Eigen::Vector3d& p_camera) {
  const cv::Matx33d camera(intrinsics.focal[0], 0.0, intrinsics.centre[0], 0.0, intrinsics.focal[1],
                           intrinsics.centre[1], 0.0, 0.0, 1.0);
  const std::vector<cv::Point3d> points{{p_camera.x(), p_camera.y(), p_camera.z()}};
  const cv::Vec3d none(0.0, 0.0, 0.0);
  std::vector<cv::Point2d> pixels;
  if (intrinsics.model == "fisheye") {
    cv::fisheye::projectPoints(points, pixels, none, none, camera, intrinsics.distortion);
  } else {
    cv::projectPoints(points, none, none, camera, intrinsics.distortion, pixels);
  }
  return pixels.front();
}

TEST(LensTest, ProjectsAsOpenCvDoes) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> side(-0.9, 0.9);
  std::uniform_real_distribution<double> depth(1.0, 9.0);
  for (const auto& intrinsics : manyIntrinsics()) {
    const Lens lens(intrinsics);
    for (int i = 0; i < 200; ++i) {
      const Eigen::Vector3d p = depth(random) * Eigen::Vector3d(side(random), side(random), 1.0);
      const cv::Point2d expected = projectByOpenCv(intrinsics, p);
      EXPECT_LT((lens.project(p) - Eigen::Vector2d(expected.x, expected.y)).norm(), 1e-9) << intrinsics.model;
    }
  }
}

TEST(LensTest, UnprojectsEveryPixelAndAMargin) {
  for (const auto& intrinsics : manyIntrinsics()) {
    const Lens lens(intrinsics);
    double worst = 0.0;
    for (double y = -Lens::kMargin; y < intrinsics.height + Lens::kMargin; y += 5.3) {
      for (double x = -Lens::kMargin; x < intrinsics.width + Lens::kMargin; x += 5.7) {
        const Eigen::Vector3d ray = lens.unproject({x, y});
        EXPECT_NEAR(ray.norm(), 1.0, 1e-12);
        worst = std::max(worst, (lens.project(ray) - Eigen::Vector2d(x, y)).norm());
      }
    }
    EXPECT_LT(worst, 1e-6) << intrinsics.model;
  }
}

TEST(LensTest, FisheyeSeesMoreThanHalfTheSphere) {
  RobotConfig::Intrinsics intrinsics = makeIntrinsics("fisheye", {0.0, 0.0, 0.0, 0.0});
  intrinsics.focal = {180.0, 180.0};
  const Lens lens(intrinsics);
  const Eigen::Vector3d ray = lens.unproject({0.0, 236.5});
  EXPECT_LT(ray.z(), 0.0);
  EXPECT_NEAR(std::atan2(-ray.x(), ray.z()), 322.75 / 180.0, 1e-12);
}

TEST(LensTest, RefusesALensThatFoldsThePicture) {
  const auto errorOf = [](const RobotConfig::Intrinsics& intrinsics) {
    return test::errorOf([&] { Lens{intrinsics}; });
  };
  EXPECT_THAT(
      errorOf(makeIntrinsics("pinhole", {-0.6, 0.0, 0.0, 0.0})),
      AllOf(HasSubstr("robot.camera"), HasSubstr("pinhole"), HasSubstr("-0.6"), HasSubstr("correct")));
  EXPECT_THAT(errorOf(makeIntrinsics("fisheye", {-0.5, 0.0, 0.0, 0.0})), HasSubstr("fisheye"));
}

}  // namespace
}  // namespace rubble::arena_sim
