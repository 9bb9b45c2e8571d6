#pragma once

#include <filesystem>

#include "arena.h"
#include "motion.h"
#include "truth_map.h"

namespace rubble::arena_sim {

/// A picture of the map from above, x to the right: all walls, what was seen of them, the robot's path from
/// blue (start) to red (end), the start with its heading, and a metre as scale. Throws common::Error.
void writeTopView(const std::filesystem::path& path, const Arena& arena, const TruthMap& map,
                  const Motion& motion);

}  // namespace rubble::arena_sim
