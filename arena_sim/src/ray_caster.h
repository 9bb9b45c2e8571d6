#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "arena.h"

namespace rubble::arena_sim {

/// First wall along a ray, exactly: a uniform grid of cells with the segments that touch them, walked cell by
/// cell (Amanatides and Woo, "A Fast Voxel Traversal Algorithm for Ray Tracing", Eurographics 1987).
class RayCaster {
 public:
  /// The segments must enclose every origin that will be cast from.
  explicit RayCaster(std::span<const Segment> segments);

  /// Metres from `origin` along the unit vector `direction` to the first wall; infinity where there is none.
  /// The origin must lie within the bounding box of the segments.
  double cast(const Eigen::Vector2d& origin, const Eigen::Vector2d& direction) const;

 private:
  int cellOf(double coordinate, int axis) const;
  std::span<const int> segmentsIn(int x, int y) const;

  std::vector<Segment> segments_;
  Eigen::Vector2d lower_;
  int cells_[2];
  // Indices of the segments of cell c are in_cells_[first_[c]] .. in_cells_[first_[c + 1] - 1].
  std::vector<int> first_;
  std::vector<int> in_cells_;
};

}  // namespace rubble::arena_sim
