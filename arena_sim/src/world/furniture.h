#pragma once

#include <optional>

#include "world/site.h"

namespace rubble::arena_sim {

/// Crates, barrels, rubble and posts as obstacles, and boards on the floor that the robot drives over.
void buildFurniture(Site& site, Random& random);

/// Something round at p leaves the start, all doors and ramp fields alone, and the robot passes it on at
/// least one side.
bool isFree(const Site& site, const Footprint& footprint);

/// The room that p is inside of.
std::optional<std::size_t> roomAt(const FloorPlan& plan, const Eigen::Vector2d& p);

/// A crate about p with the sides `size`, as an obstacle.
void addCrate(Site& site, const common::Pose2& T_arena_crate, const Eigen::Vector3d& size, double bottom,
              Random& random);

}  // namespace rubble::arena_sim
