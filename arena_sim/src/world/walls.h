#pragma once

#include "world/site.h"

namespace rubble::arena_sim {

/// Boards along all walls of the plan, frames around some doors, the patched floor, and their obstacles.
void buildWalls(Site& site, Random& random);
void buildFloor(Site& site, Random& random);

}  // namespace rubble::arena_sim
