#pragma once

#include <optional>
#include <vector>

#include "scene/mesh.h"
#include "world/crossing.h"
#include "world/floor_plan.h"
#include "world/random.h"
#include "world/world.h"

namespace rubble::arena_sim {

/// A round piece of ground that something stands on.
struct Footprint {
  Eigen::Vector2d p;
  double radius = 0.0;
};

/// The arena while it is built. Frame `arena`: the origin in a corner of the outer wall, x along its width;
/// makeWorld moves all to `world` at the end.
struct Site {
  WorldConfig config;
  FloorPlan plan;
  common::Pose2 start;
  Scene scene;
  std::vector<WorldObject> objects;
  std::vector<Segment> obstacles;
  std::vector<Footprint> footprints;
  std::vector<Polygon> ramp_fields;

  void addObstacle(const Polygon& outline);
};

/// A rectangle of `size` about T_arena_rectangle, counter-clockwise.
Polygon rectangle(const common::Pose2& T_arena_rectangle, const Eigen::Vector2d& size);

/// The rectangle around a piece of wall.
Polygon thicken(const Segment& line, double thickness);

/// Cells (m) of boards, whose light changes less than that of the floor.
inline constexpr float kBoardCell = 0.24F;

/// Random material for boards: OSB, plywood, planks, or plain paint for `plain_share` of them.
Appearance boardLook(Random& random, double plain_share);

/// A solid over a convex outline from `bottom` to the level height `top`.
void addLevelPrism(Scene& scene, const Polygon& outline, double bottom, double top, const Appearance& look,
                   bool drivable = false, float cell = kBoardCell);

}  // namespace rubble::arena_sim
