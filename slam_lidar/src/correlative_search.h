#pragma once

#include <vector>

#include "match_kernel.h"

namespace rubble::slam_lidar {

struct SearchWindow {
  common::Pose2 T_world_centre;
  double distance = 0.0;  ///< metres, half width in x and y
  double angle = 0.0;     ///< radians, half width
};

struct SearchCandidate {
  common::Pose2 T_world_lidar;
  double value = 0.0;
};

/// Exhaustive correlation of a scan with one grid (Olson, "Real-Time Correlative Scan Matching", ICRA 2009,
/// with the coarse grid as the low-resolution table): steps of one cell and of the angle that moves a typical
/// point by one cell, or multiples where that would be more than 20000 poses. Deterministic.
class CorrelativeSearch {
 public:
  /// Up to `count` best poses, best first, which differ by more than two steps. The value of a pose is
  /// MatchSums::quality() over the total weight, less `slope` times its normalised distance from the centre
  /// (0 at the centre, 1 on the border), which settles what the map leaves open.
  std::vector<SearchCandidate> search(const TiledGrid& grid, const PointSet& points,
                                      const SearchWindow& window, double slope, std::size_t count);

 private:
  void thin(const PointSet& points, double cell_size);

  PointSet thinned_;
  std::vector<SearchCandidate> candidates_;
};

}  // namespace rubble::slam_lidar
