#pragma once

#include <Eigen/Core>
#include <array>

#include "common/geometry.h"

namespace rubble::slam_mono {

/// Up to four transforms T_camera_world from three world points and the unit bearings they are seen in.
struct P3pPoses {
  std::array<common::Pose3, 4> T_camera_world;
  int count = 0;
};

/// Grunert's solution (Haralick et al. 1994, section 3.1); the bearings may point anywhere. None for points
/// on a line.
P3pPoses solveP3p(const std::array<Eigen::Vector3d, 3>& points_world,
                  const std::array<Eigen::Vector3d, 3>& bearings);

}  // namespace rubble::slam_mono
