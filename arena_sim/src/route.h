#pragma once

#include <cstdint>

#include "arena.h"
#include "motion.h"

namespace rubble::arena_sim {

/// Half the robot's width, m: no truth comes closer to a wall.
inline constexpr double kRobotRadius = 0.25;

/// A drive through the rooms and back to the start pose that fits into `duration_s` and leaves little of it.
/// The same seed gives the same route. Throws common::Error when not even the shortest one fits.
Motion planRoute(const Arena& arena, std::uint64_t seed, double duration_s, const MotionLimits& limits);

/// The smallest distance of the body's origin to a wall over the whole motion, m.
double smallestClearance(const Arena& arena, const Motion& motion);

}  // namespace rubble::arena_sim
