#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "common/geometry.h"
#include "slam_mono/camera.h"

namespace rubble::slam_mono {

/// One map point seen in the picture.
struct PointObservation {
  Eigen::Vector3d p_mono_point;
  Eigen::Vector2d pixel;
  double sigma = 1.0;  ///< pixels, standard deviation of the feature (its pyramid level's scale)
  /// One standard deviation of the point along its least certain direction, in `mono`.
  Eigen::Vector3d uncertainty = Eigen::Vector3d::Zero();
};

/// Squared normalised reprojection error above which an observation is an outlier: chi2, 2 dof, 95 %.
inline constexpr double kChi2Two = 5.991;

struct PoseOptimum {
  common::Pose3 T_camera_mono;
  /// Of a small motion of the camera in `mono`: (x, y, z; rotation vector), at one pixel of noise on level 0
  /// scaled by the residuals (never below 1). As mono_pose_t has it: p_mono_camera and its rotation in mono.
  Eigen::Matrix<double, 6, 6> covariance;
  std::vector<bool> inliers;  ///< per observation
  int inlier_count = 0;
};

/// Camera pose from 2D-3D observations: Levenberg-Marquardt on the Huber-weighted reprojection error,
/// outliers set aside and tried again between four rounds (ORB-SLAM section V-B's pose optimisation). A point
/// counts less along the line on which its uncertainty (five times that: see kInCommon) shows in the picture,
/// but is an inlier only if the feature's own noise explains its error. With fewer than three inliers the
/// pose is returned as far as it came, with an infinite covariance.
PoseOptimum optimizePose(const Camera& camera, const common::Pose3& T_camera_mono_start,
                         std::span<const PointObservation> observations);

/// d pixel / d (translation; rotation) for T_camera_mono <- exp(delta) * T_camera_mono, delta = (t; w):
/// p_camera <- p_camera + t + w x p_camera.
Eigen::Matrix<double, 2, 6> poseJacobian(const Camera& camera, const Eigen::Vector3d& p_camera);

/// exp(delta) * T for delta = (translation; rotation vector): R <- Exp(w) R, t <- Exp(w) t + v.
common::Pose3 perturbed(const common::Pose3& T, const Eigen::Matrix<double, 6, 1>& delta);

}  // namespace rubble::slam_mono
