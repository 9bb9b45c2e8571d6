#pragma once

#include <string>

#include "world/world.h"

namespace rubble::arena_sim {

/// What truth/objects.csv holds.
std::string objectTable(const World& world);

}  // namespace rubble::arena_sim
