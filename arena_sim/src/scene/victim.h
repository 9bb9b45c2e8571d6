#pragma once

#include <cstdint>
#include <vector>

#include "common/geometry.h"
#include "scene/scene.h"

namespace rubble::arena_sim {

/// A doll of about 0.55 m lying on its back or curled up on its side, or sitting against a cardboard box, by
/// its seed: head with face and hair, torso, arms and legs of rounded shapes, dressed. The origin is on the
/// ground under the middle of the torso, x towards the head (sitting: towards the box at its back), z up; all
/// of it lies within 0.35 m of the origin's vertical. Appends to `surfaces`; rounded parts carry smooth
/// normals.
void addVictim(std::vector<Surface>& surfaces, const common::Pose3& T_world_victim, std::uint64_t seed);

}  // namespace rubble::arena_sim
