#include "calibration/lens.h"

#include <opencv2/calib3d.hpp>

namespace rubble::calibration {

std::vector<cv::Point2f> Lens::undistorted(const std::vector<cv::Point2f>& pixels) const {
  std::vector<cv::Point2f> points;
  if (is_fisheye) {
    cv::fisheye::undistortPoints(pixels, points, K, distortion);
    return points;
  }
  constexpr int kIterations = 100;
  constexpr double kEnough = 1e-9;
  cv::undistortPoints(pixels, points, K, distortion, cv::noArray(), cv::noArray(),
                      {cv::TermCriteria::COUNT | cv::TermCriteria::EPS, kIterations, kEnough});
  return points;
}

Lens lensFromConfig(const common::RobotConfig::Intrinsics& intrinsics) {
  Lens lens;
  lens.size = {intrinsics.width, intrinsics.height};
  lens.is_fisheye = intrinsics.model == "fisheye";
  lens.K = {intrinsics.focal[0],
            0.0,
            intrinsics.centre[0],
            0.0,
            intrinsics.focal[1],
            intrinsics.centre[1],
            0.0,
            0.0,
            1.0};
  lens.distortion = intrinsics.distortion;
  return lens;
}

common::Pose3 poseFromOpenCv(const cv::Vec3d& rotation, const cv::Vec3d& translation) {
  const Eigen::Vector3d turn(rotation[0], rotation[1], rotation[2]);
  common::Pose3 T = common::Pose3::Identity();
  if (turn.norm() > 0.0) {
    T.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
  }
  T.translation() = Eigen::Vector3d(translation[0], translation[1], translation[2]);
  return T;
}

}  // namespace rubble::calibration
