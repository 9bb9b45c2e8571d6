#pragma once

#include <Eigen/Core>
#include <optional>

#include "geometry/pose_optimizer.h"
#include "geometry/two_view.h"
#include "slam_mono/camera.h"

namespace rubble::slam_mono {

/// chi2, 95 %: of an epipolar distance, one dof.
inline constexpr double kChi2One = 3.841;

/// A match as two bearings, and how these move with their pixels.
struct RayPair {
  Eigen::Vector2d pixel_a, pixel_b;
  Eigen::Vector3d a, b;
  Eigen::Matrix<double, 3, 2> da, db;  ///< d bearing / d pixel
  double inverse_variance = 1.0;       ///< of a pixel
};

/// Empty where the lens model has no inverse.
std::optional<RayPair> rayPair(const Camera& camera, const TwoViewMatch& match);

/// E = [t]x R.
Eigen::Matrix3d essentialOf(const common::Pose3& T_b_a);

/// b^T E a of a pair and its derivatives by both pixels.
struct EpipolarError {
  double value;
  Eigen::Vector2d by_pixel_a, by_pixel_b;

  EpipolarError(const Eigen::Matrix3d& E, const RayPair& pair)
      : value(pair.b.dot(E * pair.a)),
        by_pixel_a(pair.da.transpose() * (E.transpose() * pair.b)),
        by_pixel_b(pair.db.transpose() * (E * pair.a)) {}
  double squaredSlope() const { return by_pixel_a.squaredNorm() + by_pixel_b.squaredNorm() + 1e-30; }
  /// Sampson's distance squared, of variance 1: to first order the reprojection error in both pictures with
  /// the point eliminated (Hartley & Zisserman 2004, section 11.4.3).
  double chi2(const RayPair& pair) const { return value * value * pair.inverse_variance / squaredSlope(); }
};

/// Of a rotation or homography, p_b ~ H p_a, Hi its inverse: mean squared transfer error in both pictures, of
/// variance 1 (both pixels are noisy, hence half the squared distance).
double transferChi2(const Camera& camera, const Eigen::Matrix3d& H, const Eigen::Matrix3d& Hi,
                    const RayPair& pair);

}  // namespace rubble::slam_mono
