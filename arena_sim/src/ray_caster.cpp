#include "ray_caster.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "common/error.h"

namespace rubble::arena_sim {

namespace {

using Eigen::Vector2d;

constexpr double kCellSize = 0.25;
constexpr double kNone = std::numeric_limits<double>::infinity();

/// Metres along the ray to the segment, infinity when it passes.
double intersect(const Vector2d& origin, const Vector2d& direction, const Segment& segment) {
  const Vector2d along = segment.b - segment.a;
  const Vector2d to_a = segment.a - origin;
  const double denominator = direction.x() * along.y() - direction.y() * along.x();
  const double t = (to_a.x() * along.y() - to_a.y() * along.x()) / denominator;
  const double u = (to_a.x() * direction.y() - to_a.y() * direction.x()) / denominator;
  // A parallel ray divides by zero, and no comparison with NaN holds.
  // A hair longer than the segment, so that corners are closed.
  constexpr double kHair = 1e-9;
  return t >= 0.0 && u >= -kHair && u <= 1.0 + kHair ? t : kNone;
}

}  // namespace

RayCaster::RayCaster(std::span<const Segment> segments) : segments_(segments.begin(), segments.end()) {
  RUBBLE_CHECK(!segments_.empty());
  lower_ = segments_.front().a;
  Vector2d upper = lower_;
  for (const Segment& s : segments_) {
    lower_ = lower_.cwiseMin(s.a).cwiseMin(s.b);
    upper = upper.cwiseMax(s.a).cwiseMax(s.b);
  }
  for (int axis = 0; axis < 2; ++axis) {
    cells_[axis] = 1 + static_cast<int>((upper[axis] - lower_[axis]) / kCellSize);
  }
  // A cell holds every segment that comes within its circumscribed circle.
  const double reach = kCellSize * 0.5 * std::numbers::sqrt2 + 1e-9;
  for (int y = 0; y < cells_[1]; ++y) {
    for (int x = 0; x < cells_[0]; ++x) {
      first_.push_back(static_cast<int>(in_cells_.size()));
      const Vector2d centre = lower_ + kCellSize * Vector2d(x + 0.5, y + 0.5);
      for (std::size_t i = 0; i < segments_.size(); ++i) {
        if (distanceTo(segments_[i], centre) <= reach) {
          in_cells_.push_back(static_cast<int>(i));
        }
      }
    }
  }
  first_.push_back(static_cast<int>(in_cells_.size()));
}

int RayCaster::cellOf(double coordinate, int axis) const {
  const int cell = static_cast<int>(std::floor((coordinate - lower_[axis]) / kCellSize));
  RUBBLE_CHECK(cell >= 0 && cell <= cells_[axis]);
  return std::min(cell, cells_[axis] - 1);
}

std::span<const int> RayCaster::segmentsIn(int x, int y) const {
  const auto cell = static_cast<std::size_t>(y * cells_[0] + x);
  return {in_cells_.begin() + first_[cell], in_cells_.begin() + first_[cell + 1]};
}

double RayCaster::cast(const Vector2d& origin, const Vector2d& direction) const {
  int cell[2];
  int step[2];
  double t_next[2];   // Where the ray leaves the current cell's column, row.
  double t_delta[2];  // From one column, row to the next.
  for (int axis = 0; axis < 2; ++axis) {
    cell[axis] = cellOf(origin[axis], axis);
    step[axis] = direction[axis] > 0.0 ? 1 : -1;
    const double border = lower_[axis] + kCellSize * (cell[axis] + (step[axis] > 0 ? 1 : 0));
    t_next[axis] = direction[axis] == 0.0 ? kNone : (border - origin[axis]) / direction[axis];
    t_delta[axis] = direction[axis] == 0.0 ? kNone : kCellSize / std::abs(direction[axis]);
  }
  double nearest = kNone;
  while (cell[0] >= 0 && cell[0] < cells_[0] && cell[1] >= 0 && cell[1] < cells_[1]) {
    for (const int i : segmentsIn(cell[0], cell[1])) {
      nearest = std::min(nearest, intersect(origin, direction, segments_[static_cast<std::size_t>(i)]));
    }
    const int axis = t_next[0] < t_next[1] ? 0 : 1;
    // A hit beyond this cell may be hidden by a segment of a cell before it.
    if (nearest <= t_next[axis]) {
      break;
    }
    cell[axis] += step[axis];
    t_next[axis] += t_delta[axis];
  }
  return nearest;
}

}  // namespace rubble::arena_sim
