#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/config.h"
#include "motion/motion.h"
#include "world/world.h"

namespace rubble::arena_sim {

/// Half the robot's width, m: no truth comes closer to a wall.
inline constexpr double kRobotRadius = 0.25;

enum class MissionKind {
  kFlat,    // Rooms on a level floor.
  kRescue,  // The paper's experiment B: ground, steep ramp, U-turn on the platform, stairs, ground, home.
  kTour,    // Random goals, now and then over the platform.
};

/// How the robot drives and shakes; units in visit().
struct MotionConfig {
  double cruise_speed = 0.5;
  double turn_rate = 0.6;
  double acceleration = 0.8;
  double turn_acceleration = 2.0;
  double slip = 0.05;
  double vibration = 1.0;
};

void visit(common::ConfigSection& section, MotionConfig& config);

/// A drive from the world's origin and back to it that fits into duration_s and leaves little of it; without
/// a duration as long as is usual, longer where the world asks for it. The same arguments give the same
/// motion. Throws common::Error when not even the shortest one fits.
Motion planMission(const World& world, MissionKind kind, std::uint64_t seed, std::optional<double> duration_s,
                   const MotionConfig& config);

/// The smallest distance of the body's origin to what stops it over the whole motion, m, seen from above.
double smallestClearance(const World& world, const std::vector<common::Pose2>& poses);

}  // namespace rubble::arena_sim
