#pragma once

#include <embree3/rtcore.h>

#include <array>
#include <span>
#include <vector>

#include "scene/scene.h"
#include "sensors/worker_pool.h"

namespace rubble::arena_sim {

/// Irradiance by lamp group at full brightness: sum of power * area * cos(lamp) * cos(surface) / distance^2
/// over what a point sees of the lamps, and what the surroundings throw back.
using Irradiance = std::array<float, kLampGroups>;

/// By surface and vertex. `reflectance` of every surface: its mean. `tracer` numbers surfaces as `scene`
/// does.
std::vector<std::vector<Irradiance>> bakeLight(const Scene& scene, RTCScene tracer,
                                               std::span<const float> reflectance, WorkerPool& workers);

}  // namespace rubble::arena_sim
