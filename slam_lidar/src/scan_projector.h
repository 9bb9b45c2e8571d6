#pragma once

#include <vector>

#include "match_kernel.h"
#include "slam_lidar/grid_slam.h"

namespace rubble::slam_lidar {

/// End of one beam in the level LiDAR frame at the first beam's time, metres.
struct RayEnd {
  float x = 0.0F;
  float y = 0.0F;
  bool hit = false;  ///< false: only known to be free up to here
};

struct ProjectedScan {
  std::vector<RayEnd> rays;  ///< for the map: what ends in its slice
  PointSet points;           ///< the hits, weighted for matching
};

/// Beams to points: range limits, the LiDAR's tilt, its motion during the sweep, floor and ceiling, the map's
/// slice.
class ScanProjector {
 public:
  explicit ScanProjector(const GridSlamConfig::Scan& config) : config_(config) {}

  /// `height`: m, of the LiDAR over the middle of the map's slice. `twist`: its velocity (m/s, m/s, rad/s) in
  /// its own level frame, constant over the sweep.
  void project(const LidarScan& scan, const Attitude& first, const Attitude& last, double height,
               const Eigen::Vector3d& twist, ProjectedScan& out);

 private:
  void updateDirections(const LidarScan& scan);

  GridSlamConfig::Scan config_;
  double first_angle_ = 0.0;
  double angle_step_ = 0.0;
  std::vector<Eigen::Vector2d> directions_;  ///< of the beams, in the LiDAR's plane
};

}  // namespace rubble::slam_lidar
