#pragma once

#include <span>
#include <vector>

#include "scan_projector.h"
#include "tiled_grid.h"

namespace rubble::slam_lidar {

/// Inverse sensor model: log-odds of hits and of the free cells before them (Thrun, Burgard, Fox,
/// "Probabilistic Robotics", 9.2; Kohlbrecher et al. 2011, III-A). A cell is changed once per scan, and a hit
/// wins over free space.
class ScanWriter {
 public:
  explicit ScanWriter(const GridSlamConfig& config);

  void write(TiledGrid& grid, const common::Pose2& T_world_lidar, std::span<const RayEnd> rays,
             std::uint64_t revision);

 private:
  void traceFree(TiledGrid& grid, const Eigen::Vector2i& from, const Eigen::Vector2i& to) const;

  int hit_;
  int miss_;
  int limit_;
  double free_space_range_;
  std::vector<Eigen::Vector2i> ends_;
};

}  // namespace rubble::slam_lidar
