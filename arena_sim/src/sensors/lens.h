#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "common/robot_config.h"

namespace rubble::arena_sim {

/// The lens of a calibrated camera: rays to pixels and back. Pinhole with radial-tangential distortion
/// (k1 k2 p1 p2) or equidistant fisheye (k1 .. k4: Kannala and Brandt, PAMI 2006, as OpenCV's cv::fisheye).
/// The centre of the first pixel is (0, 0).
class Lens {
 public:
  /// Pixels around the picture for which unproject holds, too.
  static constexpr double kMargin = 8.0;

  /// Throws common::Error when the distortion cannot be inverted over the whole picture.
  explicit Lens(const common::RobotConfig::Intrinsics& intrinsics);

  /// Pixel of p_camera (optical frame, in front of the camera).
  Eigen::Vector2d project(const Eigen::Vector3d& p_camera) const;

  /// Unit ray in the optical frame through a pixel, exact to 1e-6 pixels.
  Eigen::Vector3d unproject(const Eigen::Vector2d& pixel) const;

 private:
  std::optional<Eigen::Vector3d> tryUnproject(const Eigen::Vector2d& pixel) const;
  std::optional<Eigen::Vector2d> undistortPinhole(const Eigen::Vector2d& distorted) const;
  Eigen::Vector2d distortPinhole(const Eigen::Vector2d& p, Eigen::Matrix2d* jacobian) const;
  double distortRadius(double radius) const;
  double radiusSlope(double radius) const;
  double undistortRadius(double distorted) const;
  double findLimit() const;
  void requireInvertible(const common::RobotConfig::Intrinsics& intrinsics) const;

  const bool is_fisheye_;
  const Eigen::Vector2d focal_;
  const Eigen::Vector2d centre_;
  /// Of the odd polynomial in the radius: tan of the angle to the axis (pinhole) or the angle itself
  /// (fisheye).
  std::array<double, 4> radial_{};
  Eigen::Vector2d tangential_ = Eigen::Vector2d::Zero();
  /// Radius up to which the polynomial grows.
  double limit_ = 0.0;
};

}  // namespace rubble::arena_sim
