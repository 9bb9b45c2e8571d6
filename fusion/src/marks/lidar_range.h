#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "common/geometry.h"
#include "marks/sighting.h"

namespace rubble::fusion {

/// A scan as far as marks need it.
struct RangeScan {
  common::Utime utime = 0;
  double first_angle = 0.0;   ///< rad, in `lidar`
  double angle_step = 0.0;    ///< rad
  std::vector<float> ranges;  ///< m; what is no range is not finite, or not positive
};

/// How far along a bearing the obstacle stands that the LiDAR sees below or above it: walls are upright. The
/// farther the bearing passes from the scan's plane, the less sure. Empty where the scan sees nothing there.
std::optional<RangeMeasurement> rangeAlong(const Eigen::Vector3d& p_world_camera,
                                           const Eigen::Vector3d& d_world, const RangeScan& scan,
                                           const common::Pose3& T_world_lidar);

}  // namespace rubble::fusion
