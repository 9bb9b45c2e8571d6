#include "motion/clearance_grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <queue>

namespace rubble::arena_sim {

namespace {

using Eigen::Vector2d;

constexpr double kCellSize = 0.05;
constexpr double kComfort = 0.8;         // Clearance above which a way costs its length only.
constexpr double kDiscomfortCost = 3.0;  // Per metre at no clearance.
constexpr double kVisitedCost = 0.7;     // Per metre and earlier way.
constexpr double kVisitedRadius = 0.4;
constexpr double kFarthest = 1.0;  // Clearances are not told apart beyond.
constexpr double kEnd = std::numeric_limits<double>::infinity();

}  // namespace

ClearanceGrid::ClearanceGrid(const std::vector<Segment>& segments) {
  const Eigen::AlignedBox2d bounds = boundsOf(segments);
  lower_ = bounds.min();
  const Vector2d upper = bounds.max();
  width_ = 1 + static_cast<int>((upper.x() - lower_.x()) / kCellSize);
  height_ = 1 + static_cast<int>((upper.y() - lower_.y()) / kCellSize);
  clearance_.resize(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_));
  visited_.resize(clearance_.size());
  std::fill(clearance_.begin(), clearance_.end(), kFarthest);
  for (const Segment& s : segments) {
    forCellsNear(s, kFarthest, [&](std::size_t cell, double distance) {
      clearance_[cell] = std::min(clearance_[cell], distance);
    });
  }
}

template <typename Visit>
void ClearanceGrid::forCellsNear(const Segment& s, double radius, const Visit& visit) const {
  const Vector2d reach(radius, radius);
  const Vector2d low = (s.a.cwiseMin(s.b) - reach - lower_) / kCellSize;
  const Vector2d high = (s.a.cwiseMax(s.b) + reach - lower_) / kCellSize;
  for (int y = std::max(0, static_cast<int>(low.y())); y < std::min<double>(height_, high.y()); ++y) {
    for (int x = std::max(0, static_cast<int>(low.x())); x < std::min<double>(width_, high.x()); ++x) {
      const int cell = y * width_ + x;
      if (const double distance = distanceTo(s, centreOf(cell)); distance < radius) {
        visit(static_cast<std::size_t>(cell), distance);
      }
    }
  }
}

int ClearanceGrid::indexOf(const Vector2d& p) const {
  const int x = static_cast<int>(std::floor((p.x() - lower_.x()) / kCellSize));
  const int y = static_cast<int>(std::floor((p.y() - lower_.y()) / kCellSize));
  return x < 0 || y < 0 || x >= width_ || y >= height_ ? -1 : y * width_ + x;
}

Vector2d ClearanceGrid::centreOf(int index) const {
  const int x = index % width_;
  const int y = index / width_;
  return lower_ + kCellSize * Vector2d(x + 0.5, y + 0.5);
}

double ClearanceGrid::clearance(const Vector2d& p) const {
  const int index = indexOf(p);
  return index < 0 ? 0.0 : clearance_[static_cast<std::size_t>(index)];
}

std::optional<Polyline> ClearanceGrid::findWay(const Vector2d& from, const Vector2d& to,
                                               double min_clearance) const {
  // Dijkstra backwards from the goal, so that the way can be read off from the start.
  using Entry = std::pair<double, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  std::vector<double> cost(clearance_.size(), kEnd);
  std::vector<int> next(clearance_.size(), -1);
  const int start = indexOf(from);
  const int goal = indexOf(to);
  if (start < 0 || goal < 0) {
    return std::nullopt;
  }
  cost[static_cast<std::size_t>(goal)] = 0.0;
  open.emplace(0.0, goal);
  while (!open.empty() && open.top().second != start) {
    const auto [reached, cell] = open.top();
    open.pop();
    if (reached > cost[static_cast<std::size_t>(cell)]) {
      continue;
    }
    for (const auto& [dx, dy] :
         {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {1, -1}, {-1, 1}, {-1, -1}}) {
      const int neighbour = indexOf(centreOf(cell) + kCellSize * Vector2d(dx, dy));
      const auto n = static_cast<std::size_t>(neighbour);
      if (neighbour < 0 || (neighbour != start && clearance_[n] < min_clearance)) {
        continue;
      }
      const double discomfort = std::max(0.0, kComfort - clearance_[n]) / kComfort;
      const double there = reached + kCellSize * std::hypot(dx, dy) *
                                         (1.0 + kDiscomfortCost * discomfort + kVisitedCost * visited_[n]);
      if (there < cost[n]) {
        cost[n] = there;
        next[n] = cell;
        open.emplace(there, neighbour);
      }
    }
  }
  if (cost[static_cast<std::size_t>(start)] == kEnd) {
    return std::nullopt;
  }
  Polyline way{from};
  for (int cell = next[static_cast<std::size_t>(start)]; cell >= 0 && cell != goal;
       cell = next[static_cast<std::size_t>(cell)]) {
    way.push_back(centreOf(cell));
  }
  way.push_back(to);
  return cutCorners(way, min_clearance);
}

double ClearanceGrid::lowestAlong(const Vector2d& a, const Vector2d& b) const {
  const int steps = 1 + static_cast<int>((b - a).norm() / (0.5 * kCellSize));
  double lowest = kEnd;
  for (int i = 0; i <= steps; ++i) {
    lowest = std::min(lowest, clearance(a + (b - a) * (static_cast<double>(i) / steps)));
  }
  return lowest;
}

Polyline ClearanceGrid::cutCorners(const Polyline& way, double min_clearance) const {
  Polyline cut{way.front()};
  for (std::size_t i = 0; i + 1 < way.size();) {
    // As far as a straight line keeps the clearance that the way itself has, or some comfort.
    std::size_t farthest = i + 1;
    double needed = kComfort;
    for (std::size_t j = i + 1; j < way.size(); ++j) {
      needed = std::max(min_clearance, std::min(needed, 0.9 * clearance(way[j])));
      if (lowestAlong(way[i], way[j]) >= needed) {
        farthest = j;
      }
    }
    i = farthest;
    cut.push_back(way[i]);
  }
  return cut;
}

void ClearanceGrid::noteWay(const Polyline& way) {
  std::vector<bool> passed(visited_.size());
  for (std::size_t k = 0; k + 1 < way.size(); ++k) {
    forCellsNear({way[k], way[k + 1]}, kVisitedRadius,
                 [&](std::size_t cell, double) { passed[cell] = true; });
  }
  for (std::size_t i = 0; i < visited_.size(); ++i) {
    visited_[i] += passed[i] ? 1.0 : 0.0;
  }
}

}  // namespace rubble::arena_sim
