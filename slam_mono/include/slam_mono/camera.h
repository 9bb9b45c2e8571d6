#pragma once

#include <Eigen/Core>
#include <optional>

#include "common/robot_config.h"

namespace rubble::slam_mono {

/// A calibrated camera: pinhole with radial-tangential distortion (k1 k2 p1 p2, optionally k3; Brown 1971, as
/// OpenCV) or equidistant fisheye (k1 k2 k3 k4; Kannala & Brandt 2006, as OpenCV's fisheye). Points in the
/// optical frame `camera` (x right, y down, z forward), pixels of the distorted picture; the first pixel's
/// centre is (0, 0).
class Camera {
 public:
  /// Throws common::Error for an unknown model, or a distortion with a wrong number of coefficients.
  explicit Camera(const common::RobotConfig::Intrinsics& intrinsics);

  int width() const { return width_; }
  int height() const { return height_; }

  /// Pixel of a point; empty behind the camera (pinhole), at the camera's centre, or where the lens model
  /// folds back (beyond the field of view the calibration is monotonic in). May lie outside the picture.
  std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& p_camera) const;
  /// d pixel / d p_camera, where project() has a value.
  Eigen::Matrix<double, 2, 3> projectJacobian(const Eigen::Vector3d& p_camera) const;
  /// Unit vector towards what the pixel shows; project(unproject(p)) is p within 1e-6 pixels.
  Eigen::Vector3d unproject(const Eigen::Vector2d& pixel) const;

  bool contains(const Eigen::Vector2d& pixel) const {
    return pixel.x() >= 0.0 && pixel.y() >= 0.0 && pixel.x() <= width_ - 1 && pixel.y() <= height_ - 1;
  }
  /// Angle seen by one pixel at the centre, rad.
  double pixelAngle() const { return 1.0 / fx_; }

 private:
  bool fisheye_ = false;
  int width_ = 0;
  int height_ = 0;
  double fx_ = 0.0, fy_ = 0.0, cx_ = 0.0, cy_ = 0.0;
  double k_[5] = {};  ///< pinhole: k1 k2 p1 p2 k3; fisheye: k1 k2 k3 k4 0
  double max_radius_ =
      0;  ///< pinhole: |(x, y)| / z, fisheye: angle from the axis, up to which the model grows
};

}  // namespace rubble::slam_mono
