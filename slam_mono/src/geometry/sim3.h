#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/geometry.h"
#include "slam_mono/camera.h"

namespace rubble::slam_mono {

/// Similarity S_a_b: p_a = scale * R * p_b + t.
struct Sim3 {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
  double scale = 1.0;

  Sim3() = default;
  Sim3(const Eigen::Quaterniond& q, const Eigen::Vector3d& t, double s)
      : rotation(q), translation(t), scale(s) {}
  explicit Sim3(const common::Pose3& T, double s = 1.0)
      : rotation(T.linear()), translation(T.translation()), scale(s) {}

  Eigen::Vector3d operator*(const Eigen::Vector3d& p_b) const {
    return scale * (rotation * p_b) + translation;
  }
  Sim3 operator*(const Sim3& S_b_c) const {
    return {(rotation * S_b_c.rotation).normalized(), *this * S_b_c.translation, scale * S_b_c.scale};
  }
  Sim3 inverse() const {
    const Eigen::Quaterniond q = rotation.conjugate();
    return {q, -(q * translation) / scale, 1.0 / scale};
  }
  /// The rigid transform with the same rotation that maps the origin alike when lengths are divided by scale:
  /// [sR t] as a camera pose is [R t/s].
  common::Pose3 normalized() const {
    common::Pose3 T = common::Pose3::Identity();
    T.linear() = rotation.toRotationMatrix();
    T.translation() = translation / scale;
    return T;
  }
};

/// One point that two keyframes a and b know in their own camera frames, and where each sees it.
struct PointPair {
  Eigen::Vector3d p_a;  ///< in a's camera frame
  Eigen::Vector3d p_b;  ///< in b's camera frame
  Eigen::Vector2d pixel_a;
  Eigen::Vector2d pixel_b;
  double sigma_a = 1.0;  ///< pixels
  double sigma_b = 1.0;
};

struct Sim3Config {
  int iterations = 300;
  int min_inliers = 20;
  double max_error = 3.0;  ///< times sigma, of an inlier, in both pictures
  std::uint64_t seed = 1;
};

struct Sim3Result {
  Sim3 S_a_b;
  std::vector<bool> inliers;
  int inlier_count = 0;
};

/// Horn's closed form in RANSAC over three pairs, inliers by reprojection in both pictures, then
/// refineSim3. Empty when fewer than min_inliers agree.
std::optional<Sim3Result> solveSim3(const Camera& camera, std::span<const PointPair> pairs,
                                    const Sim3Config& config);

/// Levenberg-Marquardt (Huber) over the reprojection errors in both pictures, from S_a_b_start; inliers by
/// max_error at the end.
Sim3Result refineSim3(const Camera& camera, std::span<const PointPair> pairs, const Sim3& S_a_b_start,
                      double max_error);

}  // namespace rubble::slam_mono
