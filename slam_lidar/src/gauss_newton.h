#pragma once

#include <span>

#include "match_kernel.h"

namespace rubble::slam_lidar {

struct Match {
  common::Pose2 T_world_lidar;
  MatchSums sums;  ///< at the pose, on the finest level
  int iterations = 0;
};

/// Scan-to-map alignment by Gauss-Newton on sum w (1 - M)^2 (Kohlbrecher et al. 2011, IV-B, eq. 7-13), from
/// the coarsest of `levels` (finest first) to the finest.
Match alignScan(std::span<const TiledGrid> levels, const PointSet& points, const common::Pose2& T_world_seed,
                int max_iterations);

}  // namespace rubble::slam_lidar
