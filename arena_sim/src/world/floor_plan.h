#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "world/crossing.h"
#include "world/polygon.h"
#include "world/random.h"
#include "world/world.h"

namespace rubble::arena_sim {

struct Door {
  Eigen::Vector2d centre;
  Eigen::Vector2d along;  // Unit, along the wall.
  double width = 0.0;
};

/// A straight wall without openings.
struct WallPiece {
  Segment line;
  double thickness = 0.03;
  bool outer = false;
};

/// Where walls, doors and the crossing are. Frame `arena`.
struct FloorPlan {
  Eigen::Vector2d size = Eigen::Vector2d::Zero();
  std::vector<Polygon> rooms;
  std::vector<WallPiece> walls;
  std::vector<Door> doors;
  std::optional<CrossingPlan> crossing;
  /// The room in front of ramp and stairs.
  std::optional<std::size_t> approach;
};

/// Rooms and corridors by recursive division with straight or slanted walls and doors in every one, around
/// the crossing in a corner or at a side. Throws common::Error when the arena is too small for it.
FloorPlan drawFloorPlan(const WorldConfig& config, Random& random);

}  // namespace rubble::arena_sim
