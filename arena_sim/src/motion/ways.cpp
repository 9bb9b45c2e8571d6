#include "motion/ways.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace rubble::arena_sim {

namespace {

using Eigen::Vector2d;

constexpr double kArcStep = 0.06;

bool isClear(const Polyline& way, const ClearanceGrid& grid, double min_clearance) {
  for (std::size_t i = 1; i < way.size(); ++i) {
    if (grid.lowestAlong(way[i - 1], way[i]) < min_clearance) {
      return false;
    }
  }
  return true;
}

/// From angle `from` by `sweep` around the centre.
Polyline arcAround(const Vector2d& centre, double radius, double from, double sweep) {
  const int pieces = std::max(1, static_cast<int>(std::ceil(std::abs(sweep) * radius / kArcStep)));
  Polyline arc;
  for (int i = 0; i <= pieces; ++i) {
    const double angle = from + sweep * i / pieces;
    arc.emplace_back(centre + radius * Vector2d(std::cos(angle), std::sin(angle)));
  }
  return arc;
}

/// The arc that touches both legs of a corner, `reach` from it.
Polyline fillet(const Vector2d& corner, const Vector2d& in, double reach, double turn) {
  const double radius = reach / std::tan(0.5 * std::abs(turn));
  const double side = turn > 0.0 ? 1.0 : -1.0;
  const Vector2d left(-in.y(), in.x());
  const Vector2d centre = corner - reach * in + side * radius * left;
  const Vector2d from = -side * left;
  return arcAround(centre, radius, std::atan2(from.y(), from.x()), turn);
}

}  // namespace

double lengthOf(const Polyline& way) {
  double length = 0.0;
  for (std::size_t i = 1; i < way.size(); ++i) {
    length += (way[i] - way[i - 1]).norm();
  }
  return length;
}

Polyline roundCorners(const Polyline& way, const ClearanceGrid& grid, double min_clearance) {
  constexpr double kStraight = 0.1;
  Polyline round{way.front()};
  for (std::size_t i = 1; i + 1 < way.size(); ++i) {
    const double before = (way[i] - way[i - 1]).norm();
    const double after = (way[i + 1] - way[i]).norm();
    const Vector2d in = (way[i] - way[i - 1]) / before;
    const Vector2d out = (way[i + 1] - way[i]) / after;
    const double turn = std::atan2(in.x() * out.y() - in.y() * out.x(), in.dot(out));
    bool done = false;
    if (std::abs(turn) > kStraight && std::abs(turn) < 2.6) {
      for (const double radius : {0.8, 0.6, 0.45, 0.3}) {
        const double reach = std::min(radius * std::tan(0.5 * std::abs(turn)), 0.5 * std::min(before, after));
        const Polyline arc = fillet(way[i], in, reach, turn);
        if (isClear(arc, grid, min_clearance)) {
          round.insert(round.end(), arc.begin(), arc.end());
          done = true;
          break;
        }
      }
    }
    if (!done) {
      round.push_back(way[i]);
    }
  }
  round.push_back(way.back());
  return round;
}

Polyline beginWithCurve(const Polyline& way, const common::Pose2& pose, const ClearanceGrid& grid,
                        double min_clearance) {
  constexpr double kAlongEnough = 0.4;  // rad
  constexpr double kWidestSweep = 3.6;  // rad
  const Vector2d here = pose.translation();
  const auto headingTo = [&](const Vector2d& p) {
    return common::wrapAngle(std::atan2(p.y() - here.y(), p.x() - here.x()) - pose.yaw);
  };
  if (std::abs(headingTo(way[1])) < kAlongEnough) {
    return way;
  }
  // Points of the way that the curve may aim at.
  Polyline dense{way.front()};
  for (std::size_t i = 1; i < way.size(); ++i) {
    const int pieces = std::max(1, static_cast<int>((way[i] - way[i - 1]).norm() / 0.2));
    for (int k = 1; k <= pieces; ++k) {
      dense.emplace_back(way[i - 1] + (way[i] - way[i - 1]) * (static_cast<double>(k) / pieces));
    }
  }
  Polyline best = way;
  double shortest = lengthOf(way) + 3.0;  // What a turn on the spot is worth.
  for (const double radius : {0.6, 0.45}) {
    for (const double side : {1.0, -1.0}) {
      const Vector2d centre = pose * Vector2d(0.0, side * radius);
      const double from = pose.yaw - side * 0.5 * std::numbers::pi;
      for (std::size_t i = 1; i < std::min<std::size_t>(dense.size(), 20); ++i) {
        const Vector2d d = dense[i] - centre;
        if (d.norm() < 1.05 * radius) {
          continue;
        }
        const double touch = std::atan2(d.y(), d.x()) - side * std::acos(radius / d.norm());
        double sweep = std::fmod(side * (touch - from), 2.0 * std::numbers::pi);
        sweep += sweep < 0.0 ? 2.0 * std::numbers::pi : 0.0;
        if (sweep > kWidestSweep) {
          continue;
        }
        Polyline curve = arcAround(centre, radius, from, side * sweep);
        curve.insert(curve.end(), dense.begin() + static_cast<std::ptrdiff_t>(i), dense.end());
        const double length = lengthOf(curve);
        const Polyline begin(curve.begin(), curve.end() - static_cast<std::ptrdiff_t>(dense.size() - i - 1));
        if (length < shortest && isClear(begin, grid, min_clearance)) {
          shortest = length;
          best = curve;
        }
      }
    }
  }
  return best;
}

}  // namespace rubble::arena_sim
