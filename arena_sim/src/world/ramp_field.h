#pragma once

#include "world/site.h"

namespace rubble::arena_sim {

/// Covers one or two rooms with RoboCup's pitch and roll ramps: cells of wedges, at most 0.16 m high.
void buildRampFields(Site& site, Random& random);

}  // namespace rubble::arena_sim
