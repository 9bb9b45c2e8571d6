#pragma once

#include <cstdint>
#include <vector>

#include "common/geometry.h"
#include "motion/route.h"
#include "motion/terrain.h"

namespace rubble::arena_sim {

/// T_world_body in which the tracks rest on the terrain with the robot at x, y, yaw: the lowest centre of
/// mass with no part of a track under the ground. The origin is under the robot's centre, on the tracks'
/// plane.
common::Pose3 restOn(const Terrain& terrain, const common::Pose2& pose);

/// Drives the plan (samples Motion::kStep apart) over the terrain: T_world_body with sprung suspension, tips
/// over edges, and the tracks' vibration.
std::vector<common::Pose3> ride(const Terrain& terrain, const std::vector<common::Pose2>& plan,
                                const MotionConfig& config, std::uint64_t seed);

}  // namespace rubble::arena_sim
