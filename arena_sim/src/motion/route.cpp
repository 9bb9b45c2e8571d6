#include "motion/route.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "common/error.h"
#include "motion/planner.h"
#include "motion/terrain.h"
#include "motion/vehicle.h"

namespace rubble::arena_sim {

namespace {

using Eigen::Vector2d;

constexpr double kRescueLength = 30.2;  // m seen from above; slopes and curves come on top.
// How long missions usually take, s.
constexpr double kFlatDuration = 75.0;
constexpr double kRescueDuration = 180.0;
constexpr double kTourDuration = 300.0;
constexpr int kMisses = 4;  // Goals too far away before no more are tried.

[[noreturn]] void failTooShort(const char* mission, double duration_s, double needed_s) {
  throw common::Error(
      fmt::format("the mission `{}` does not fit into {} s: with this seed it needs at least {} s", mission,
                  duration_s, std::ceil(needed_s)));
}

/// Goals as long as the way home from the last one fits. Every fourth leg of a tour goes over the platform.
Planner planGoals(const World& world, bool with_crossing, std::uint64_t seed, double duration_s,
                  const MotionConfig& config, const char* name) {
  Planner open(world, config, seed);
  Planner fitting = open;
  fitting.goHome();
  if (fitting.seconds() > duration_s) {
    failTooShort(name, duration_s, fitting.seconds());
  }
  for (int legs = 1, misses = 0; misses < kMisses; ++legs) {
    Planner longer = open;
    for (int skipped = 0; skipped < misses; ++skipped) {
      longer.skipRoom();
    }
    if (with_crossing && legs % 4 == 2 && misses == 0) {
      longer.addCrossing();
    } else {
      longer.addGoal();
    }
    Planner closed = longer;
    closed.goHome();
    if (closed.seconds() <= duration_s) {
      open = std::move(longer);
      fitting = std::move(closed);
      misses = 0;
    } else {
      ++misses;
    }
  }
  return fitting;
}

/// Ground with a ramp field, the crossing, ground again and home.
Planner planRescue(const World& world, std::uint64_t seed, std::optional<double> wanted_s,
                   const MotionConfig& config) {
  if (!world.crossing) {
    throw common::Error("the mission `rescue` leads over the crossing; set arena_sim.world.crossing: true");
  }
  const double duration_s = wanted_s.value_or(kRescueDuration);
  Planner open(world, config, seed);
  open.addRampField();
  std::optional<Planner> fitting;
  for (int goals = 0, misses = 0; misses < kMisses; ++goals) {
    Planner closed = open;
    closed.addCrossing();
    for (int after = 0; after < 1 + goals / 3; ++after) {
      closed.addGoal();
    }
    closed.goHome();
    if (closed.length() >= kRescueLength) {
      if (closed.seconds() <= duration_s) {
        fitting = std::move(closed);
      } else if (fitting) {
        ++misses;
      } else if (wanted_s) {
        failTooShort("rescue", duration_s, closed.seconds());
      } else {
        return closed;
      }
    }
    open.addGoal();
  }
  return *fitting;
}

/// The slowest drive of the plan that still fits.
std::vector<common::Pose2> stretch(const Planner& plan, double duration_s) {
  double slow = 0.5;
  double fast = 1.0;
  std::vector<common::Pose2> best = plan.poses();
  constexpr int kHalvings = 5;
  for (int i = 0; i < kHalvings; ++i) {
    const double share = 0.5 * (slow + fast);
    std::vector<common::Pose2> poses = plan.driveAgain(share);
    if (static_cast<double>(poses.size() - 1) * Motion::kStep <= duration_s) {
      best = std::move(poses);
      fast = share;
    } else {
      slow = share;
    }
  }
  return best;
}

}  // namespace

void visit(common::ConfigSection& section, MotionConfig& config) {
  section.number("cruise_speed", config.cruise_speed, "m/s", 0.1, 0.8,
                 "on level ground; legs vary around it");
  section.number("turn_rate", config.turn_rate, "rad/s", 0.2, 3.0, "fastest turn");
  section.number("acceleration", config.acceleration, "m/s^2", 0.1, 5.0, "speeding up and braking");
  section.number("turn_acceleration", config.turn_acceleration, "rad/s^2", 0.5, 30.0,
                 "beginning and ending turns");
  section.number("slip", config.slip, "", 0.0, 0.3, "of the tracks on level ground, 1 sigma; more on slopes");
  section.number("vibration", config.vibration, "", 0.0, 5.0,
                 "1: 0.15 degrees and 0.5 mm at 0.5 m/s, 1 sigma");
}

Motion planMission(const World& world, MissionKind kind, std::uint64_t seed, std::optional<double> duration_s,
                   const MotionConfig& config) {
  std::vector<common::Pose2> poses;
  switch (kind) {
    case MissionKind::kFlat: {
      const double most = duration_s.value_or(kFlatDuration);
      poses = stretch(planGoals(world, false, seed, most, config, "flat"), most);
      break;
    }
    case MissionKind::kRescue:
      poses = stretch(planRescue(world, seed, duration_s, config), duration_s.value_or(kRescueDuration));
      break;
    case MissionKind::kTour: {
      const double most = duration_s.value_or(kTourDuration);
      poses = stretch(planGoals(world, world.crossing.has_value(), seed, most, config, "tour"), most);
      break;
    }
  }
  if (smallestClearance(world, poses) < kRobotRadius) {
    throw common::Error(
        "the robot bumps into a wall; arena_sim.motion.turn_rate is too slow for its cruise_speed");
  }
  return Motion(ride(Terrain(world.scene, barriersOf(world)), poses, config, seed));
}

double smallestClearance(const World& world, const std::vector<common::Pose2>& poses) {
  const std::vector<Segment> barriers = barriersOf(world);
  double smallest = std::numeric_limits<double>::max();
  for (const common::Pose2& pose : poses) {
    for (const Segment& segment : barriers) {
      smallest = std::min(smallest, distanceTo(segment, pose.translation()));
    }
  }
  return smallest;
}

}  // namespace rubble::arena_sim
