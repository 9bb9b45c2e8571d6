#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "world/polygon.h"

namespace rubble::arena_sim {

using Polyline = std::vector<Eigen::Vector2d>;

/// Distance to the nearest wall on a 5 cm grid, and ways through it. Metres, frame `world`.
class ClearanceGrid {
 public:
  explicit ClearanceGrid(const std::vector<Segment>& segments);

  /// At the cell of p, up to 1 m; 0 outside.
  double clearance(const Eigen::Vector2d& p) const;

  /// A cheap way with at least `min_clearance` everywhere but at `from`, its corners cut where that allows;
  /// it avoids where earlier ways (noteWay) went when that costs little. Empty when there is none.
  std::optional<Polyline> findWay(const Eigen::Vector2d& from, const Eigen::Vector2d& to,
                                  double min_clearance) const;

  void noteWay(const Polyline& way);

  /// The lowest clearance on the straight line between a and b.
  double lowestAlong(const Eigen::Vector2d& a, const Eigen::Vector2d& b) const;

 private:
  /// Calls visit(cell, distance) for all cells nearer than `radius` to the segment.
  template <typename Visit>
  void forCellsNear(const Segment& s, double radius, const Visit& visit) const;
  int indexOf(const Eigen::Vector2d& p) const;
  Eigen::Vector2d centreOf(int index) const;
  Polyline cutCorners(const Polyline& way, double min_clearance) const;

  Eigen::Vector2d lower_;
  int width_ = 0;
  int height_ = 0;
  std::vector<double> clearance_;
  std::vector<double> visited_;
};

}  // namespace rubble::arena_sim
