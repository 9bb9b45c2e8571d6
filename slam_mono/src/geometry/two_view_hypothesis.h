#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "common/geometry.h"
#include "geometry/ray_pair.h"
#include "slam_mono/camera.h"

namespace rubble::slam_mono {

/// A motion between two views and what speaks for it.
struct TwoViewHypothesis {
  common::Pose3 T_b_a;
  double direction_sigma = 0.0;  ///< rad
  int inliers = 0;               ///< of the epipolar geometry
  std::vector<std::optional<Eigen::Vector3d>> points_a;
  int point_count = 0;
  int strict_count = 0;  ///< of the points, inliers of the epipolar geometry too: tells motions apart better
};

/// Minimises the reprojection error of the pairs near the motion's epipolar geometry, the points eliminated.
void refineEpipolar(std::span<const RayPair> pairs, common::Pose3& T_b_a);

/// refineEpipolar over the support, then triangulates the good points of all pairs.
TwoViewHypothesis refineMotion(const Camera& camera, std::span<const RayPair> pairs,
                               std::span<const RayPair> support, const common::Pose3& T_b_a_start);

}  // namespace rubble::slam_mono
