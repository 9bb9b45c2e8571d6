#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "common/geometry.h"
#include "common/robot_config.h"
#include "slam_mono/camera.h"

namespace rubble::slam_mono {

inline common::RobotConfig::Intrinsics intrinsicsOf(const std::string& model, double focal,
                                                    std::vector<double> distortion) {
  common::RobotConfig::Intrinsics intrinsics;
  intrinsics.model = model;
  intrinsics.focal = {focal, focal * 1.01};
  intrinsics.centre = {318.2, 241.1};
  intrinsics.distortion = std::move(distortion);
  return intrinsics;
}

inline Camera arenaCamera() {
  return Camera(intrinsicsOf("pinhole", 370.0, {-0.22, 0.045, 0.0006, -0.0004}));
}
inline Camera strongCamera() { return Camera(intrinsicsOf("pinhole", 370.0, {-0.3, 0.08, 0.0, 0.0})); }
/// 229 degrees from corner to corner.
inline Camera fisheyeCamera() {
  return Camera(intrinsicsOf("fisheye", 200.0, {-0.012, 0.004, -0.002, 0.0003}));
}

/// Random numbers of the tests.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : random_(seed) {}

  double uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(random_() >> 11U) * 0x1p-53;
  }
  bool chance(double share) { return uniform(0.0, 1.0) < share; }
  /// Box-Muller.
  double normal(double sigma) {
    return sigma * std::sqrt(-2.0 * std::log(1.0 - uniform(0.0, 1.0))) *
           std::cos(2.0 * std::numbers::pi * uniform(0.0, 1.0));
  }
  Eigen::Vector2d noise(double sigma) { return {normal(sigma), normal(sigma)}; }
  Eigen::Vector3d vector(double extent) {
    return {uniform(-extent, extent), uniform(-extent, extent), uniform(-extent, extent)};
  }
  Eigen::Vector2d pixel(const Camera& camera) {
    return {uniform(0.0, camera.width() - 1.0), uniform(0.0, camera.height() - 1.0)};
  }
  common::Pose3 pose(double extent, double angle) {
    return rigid(vector(extent), uniform(0.0, angle) * vector(1.0).normalized());
  }
  static common::Pose3 rigid(const Eigen::Vector3d& t, const Eigen::Vector3d& rotation_vector) {
    common::Pose3 T = common::Pose3::Identity();
    if (rotation_vector.norm() > 0.0) {
      T.linear() = Eigen::AngleAxisd(rotation_vector.norm(), rotation_vector.normalized()).toRotationMatrix();
    }
    T.translation() = t;
    return T;
  }

 private:
  std::mt19937_64 random_;
};

inline double angleOf(const Eigen::Matrix3d& R) { return Eigen::AngleAxisd(R).angle(); }
inline double rotationError(const common::Pose3& S, const common::Pose3& T) {
  return angleOf(S.linear() * T.linear().transpose());
}
inline double angleBetween(const Eigen::Vector3d& p, const Eigen::Vector3d& q) {
  return std::atan2(p.cross(q).norm(), p.dot(q));
}
inline Eigen::Vector3d centreOf(const common::Pose3& T_camera_world) {
  return T_camera_world.inverse().translation();
}

}  // namespace rubble::slam_mono
