#pragma once

#include <Eigen/Core>
#include <vector>

namespace rubble::tools {

struct MapResult {
  double precision = 0.0;  // share of the map's occupied cells that have one of the truth near
  double recall = 0.0;     // share of the truth's occupied cells that have one of the map near
};

/// Compares centres of occupied cells (at least one each), m in one frame; near: at most `tolerance` m apart.
/// Distances are exact between any two grids, whatever their cell sizes and origins.
MapResult evaluateMap(const std::vector<Eigen::Vector2d>& map, const std::vector<Eigen::Vector2d>& truth,
                      double tolerance);

}  // namespace rubble::tools
