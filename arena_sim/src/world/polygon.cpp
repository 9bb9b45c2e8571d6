#include "polygon.h"

#include <algorithm>
#include <limits>

namespace rubble::arena_sim {

namespace {

using Eigen::Vector2d;

double cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

}  // namespace

double distanceTo(const Segment& segment, const Vector2d& p) {
  const Vector2d along = segment.b - segment.a;
  const double t = std::clamp((p - segment.a).dot(along) / along.squaredNorm(), 0.0, 1.0);
  return (p - segment.a - t * along).norm();
}

Eigen::AlignedBox2d boundsOf(const std::vector<Segment>& segments) {
  Eigen::AlignedBox2d bounds;
  for (const Segment& segment : segments) {
    bounds.extend(segment.a).extend(segment.b);
  }
  return bounds;
}

double areaOf(const Polygon& polygon) {
  double twice = 0.0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    twice += cross(polygon[i], polygon[(i + 1) % polygon.size()]);
  }
  return 0.5 * twice;
}

double spanOf(const Polygon& polygon, const Vector2d& direction) {
  double low = std::numeric_limits<double>::max();
  double high = std::numeric_limits<double>::lowest();
  for (const Vector2d& p : polygon) {
    low = std::min(low, p.dot(direction));
    high = std::max(high, p.dot(direction));
  }
  return high - low;
}

double depthInside(const Polygon& polygon, const Vector2d& p) {
  double depth = std::numeric_limits<double>::max();
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector2d edge = (polygon[(i + 1) % polygon.size()] - polygon[i]).normalized();
    depth = std::min(depth, cross(edge, p - polygon[i]));
  }
  return depth;
}

std::optional<Division> cut(const Polygon& polygon, const Vector2d& p, const Vector2d& direction) {
  Division division;
  std::vector<Vector2d> ends;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector2d& a = polygon[i];
    const Vector2d& b = polygon[(i + 1) % polygon.size()];
    const double side_a = cross(direction, a - p);
    const double side_b = cross(direction, b - p);
    (side_a >= 0.0 ? division.left : division.right).push_back(a);
    if ((side_a >= 0.0) != (side_b >= 0.0)) {
      ends.emplace_back(a + (b - a) * (side_a / (side_a - side_b)));
      division.left.push_back(ends.back());
      division.right.push_back(ends.back());
    }
  }
  if (ends.size() != 2) {
    return std::nullopt;
  }
  division.wall = {ends[0], ends[1]};
  return division;
}

}  // namespace rubble::arena_sim
