#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "common/geometry.h"

namespace rubble::fusion {

/// A picture's pose in both navigation frames.
struct AlignmentSample {
  common::Pose3 T_mono_camera;   ///< in the monocular map's scale
  common::Pose3 T_camera_lidar;  ///< m, with the plate as it stood
  common::Pose2 T_world_lidar;   ///< level: the LiDAR's origin and heading, from its own SLAM
  Eigen::Vector3d v_world_lidar = Eigen::Vector3d::Zero();  ///< its change: m/s, m/s, rad/s
  double floor = 0.0;                                       ///< m, the level's
};

/// S_world_mono: p_world = scale * R * p_mono + p.
struct Similarity {
  double scale = 1.0;  ///< metres per unit of the monocular map
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d p = Eigen::Vector3d::Zero();

  common::Pose3 operator*(const common::Pose3& T_mono_camera) const;
};

/// Weights of the alignment (standard deviations).
struct AlignmentConfig {
  double position_sigma = 0.02;  ///< m, LiDAR's x and y against vision's
  double heading_sigma = 0.01;   ///< rad
  double floor_sigma = 0.05;     ///< m, height of the body over the level's floor; robust
  double level_sigma = 0.02;     ///< rad, tilt of the body on the level's floor; robust
  double tilt_sigma = 0.002;     ///< rad, by which gravity may turn from one estimate to the next
  double scale_sigma = 0.02;     ///< share by which the scale may differ from the last one's
};

struct Alignment {
  Similarity S_world_mono;
  /// Of (rotation vector in world, position at the samples' middle, logarithm of the scale).
  Eigen::Matrix<double, 7, 7> covariance;

  double scaleSigma() const;  ///< relative
};

/// Least squares over LiDAR positions and headings (Chen et al. 2017, eq. 6 to 9, with one scale for all
/// axes: a similarity where eq. 8 gives an affine map) with the lever arm between camera and LiDAR, and what
/// the floor says about height and tilt. `prior`: what stays where the motion shows nothing (standing still,
/// straight lines, pure turns); its scale is used when `scale_known`. Empty for fewer than two samples.
std::optional<Alignment> align(std::span<const AlignmentSample> samples, const common::Pose3& T_camera_body,
                               const Similarity& prior, bool scale_known, const AlignmentConfig& config);

/// The first guess: the attitude is the given one, scale and position follow from the way between the samples
/// that are farthest apart, the first one stands on the floor. Empty while the LiDAR has moved less than
/// `min_way` (m).
std::optional<Similarity> roughAlignment(std::span<const AlignmentSample> samples,
                                         const common::Pose3& T_camera_body,
                                         const Eigen::Matrix3d& R_world_mono, double min_way);

/// The paper's scale, for comparison: eq. 8, the slopes of regressions with intercept between the LiDAR's
/// positions and those of vision along x and y, and of them what eq. 9 should have for z: sqrt((lambda_x^2 +
/// lambda_y^2) / 2). An axis without motion is left out; empty when both are.
std::optional<double> axisScale(std::span<const AlignmentSample> samples,
                                const Eigen::Matrix3d& R_world_mono);

/// Residuals of one sample and their derivatives by (rotation vector in world, position, logarithm of the
/// scale): x, y (m), heading (rad), height (m), tilt about y and -x (rad), unweighted.
using SampleResidual = Eigen::Matrix<double, 6, 1>;
using SampleJacobian = Eigen::Matrix<double, 6, 7>;
SampleResidual alignmentResidual(const AlignmentSample& sample, const common::Pose3& T_camera_body,
                                 const Similarity& S_world_mono, SampleJacobian* jacobian = nullptr);
/// Weights of a sample's squared residuals among `samples`: Huber's loss for what is always meant (position,
/// heading), Cauchy's for what holds on flat floor only.
SampleResidual sampleWeights(const SampleResidual& residual, std::size_t samples,
                             const AlignmentConfig& config);
/// exp(delta) applied from the left, the position's part added.
Similarity perturbed(const Similarity& S, const Eigen::Matrix<double, 7, 1>& delta);

}  // namespace rubble::fusion
