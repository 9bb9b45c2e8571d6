#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "geometry/pose_optimizer.h"

namespace rubble::slam_mono {

struct PnpConfig {
  int iterations = 200;  ///< of RANSAC at most; ends earlier once 0.999 sure
  int min_inliers = 15;
  double max_error = 2.5;  ///< times sigma, reprojection error of an inlier
  std::uint64_t seed = 1;
};

/// Pose of a camera that nobody has an idea of: P3P in RANSAC on bearings (so any lens), then optimizePose
/// over the inliers (Chen et al. 2017, section III-B). Empty when fewer than min_inliers agree.
std::optional<PoseOptimum> solvePnp(const Camera& camera, std::span<const PointObservation> observations,
                                    const PnpConfig& config);

}  // namespace rubble::slam_mono
