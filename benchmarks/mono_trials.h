#pragma once

#include <cstdint>

#include "synthetic_mission.h"
#include "synthetic_scenes.h"

namespace rubble::slam_mono {

inline constexpr double kTrialRate = 15.0;  // Hz

struct SeedRange {
  std::uint64_t first = 1;
  std::uint64_t last = 1;
};

/// What takes the pictures, while SLAM believes in arenaCamera().
Camera worldLens(std::uint64_t seed);

/// How well the scale survives a turn on the spot with this view, as a table on stdout.
void measureTurns(const SeedRange& seeds, const ViewConfig& view);

/// How soon another mission finds itself in a saved map, as a table on stdout.
void measureSecondMissions(const SeedRange& seeds);

/// How fast the camera finds itself again, as a table on stdout. With an exact lens nothing drifts.
void measureRecovery(int trials, bool exact_lens);

}  // namespace rubble::slam_mono
