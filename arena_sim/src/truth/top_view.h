#pragma once

#include <filesystem>

#include "motion/motion.h"
#include "truth/truth_map.h"
#include "world/world.h"

namespace rubble::arena_sim {

/// A picture of the map from above, x to the right: what was seen at the LiDAR's height, outlines of all
/// obstacles, objects by kind, the robot's path from blue (floor) to red (highest), the start with its
/// heading, and a metre as scale. Throws common::Error.
void writeTopView(const std::filesystem::path& path, const World& world, const TruthMap& map,
                  const Motion& motion);

}  // namespace rubble::arena_sim
