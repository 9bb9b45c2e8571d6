#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <vector>

// Plane geometry of walls and rooms, metres.
namespace rubble::arena_sim {

/// A straight piece of wall, infinitely thin, at the LiDAR's height. Metres, frame `world`.
struct Segment {
  Eigen::Vector2d a;
  Eigen::Vector2d b;
};

double distanceTo(const Segment& segment, const Eigen::Vector2d& p);

/// The upright rectangle around all of them.
Eigen::AlignedBox2d boundsOf(const std::vector<Segment>& segments);

/// Convex, counter-clockwise corners.
using Polygon = std::vector<Eigen::Vector2d>;

double areaOf(const Polygon& polygon);

/// Length of the polygon's shadow along a unit direction.
double spanOf(const Polygon& polygon, const Eigen::Vector2d& direction);

/// Distance of p from the nearest edge; negative outside.
double depthInside(const Polygon& polygon, const Eigen::Vector2d& p);

struct Division {
  Polygon left;
  Polygon right;
  Segment wall;
};

/// Cuts along the line through `p` in `direction`; empty when the line passes by.
std::optional<Division> cut(const Polygon& polygon, const Eigen::Vector2d& p,
                            const Eigen::Vector2d& direction);

}  // namespace rubble::arena_sim
