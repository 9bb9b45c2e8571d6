#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "config.h"
#include "motion/route.h"
#include "world/world.h"

namespace rubble::arena_sim {

/// Of a mission's folder.
inline constexpr char kCalibrationFile[] = "robot.yaml";
inline constexpr char kScenarioFile[] = "arena_sim.yaml";

/// The world of a mission of this kind; a flat one has neither crossing nor ramp fields.
World makeMissionWorld(MissionKind kind, WorldConfig config, std::uint64_t seed);

/// The world of a finished mission, built again from its scenario. A mission's folder does not name its seed,
/// so without one those below 1000 are tried; right is what gives the truth/objects.csv that lies there.
/// Throws common::Error when none does.
World restoreMissionWorld(const std::filesystem::path& mission, std::optional<std::uint64_t> seed);

}  // namespace rubble::arena_sim
