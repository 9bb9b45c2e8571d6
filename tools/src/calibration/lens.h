#pragma once

#include <opencv2/core/matx.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

#include "common/geometry.h"
#include "common/robot_config.h"

namespace rubble::calibration {

/// A camera's projection as OpenCV has it; the centre of the first pixel is (0, 0).
struct Lens {
  cv::Size size;
  bool is_fisheye = false;
  cv::Matx33d K = cv::Matx33d::eye();
  std::vector<double> distortion;  // k1 k2 p1 p2 [k3], or k1 k2 k3 k4 of the fisheye

  /// On the plane z = 1.
  std::vector<cv::Point2f> undistorted(const std::vector<cv::Point2f>& pixels) const;
};

Lens lensFromConfig(const common::RobotConfig::Intrinsics& intrinsics);

common::Pose3 poseFromOpenCv(const cv::Vec3d& rotation, const cv::Vec3d& translation);

}  // namespace rubble::calibration
