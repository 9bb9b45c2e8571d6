#pragma once

#include <vector>

#include "scene/scene.h"
#include "world/polygon.h"

namespace rubble::arena_sim {

/// Where the scene's surfaces cross the level plane at height z (m, world).
std::vector<Segment> sliceAt(const Scene& scene, double z);

}  // namespace rubble::arena_sim
