#include "mission_world.h"

#include <fmt/format.h>

#include <utility>

#include "common/error.h"
#include "common/files.h"
#include "truth/object_table.h"

namespace rubble::arena_sim {

namespace {

constexpr std::uint64_t kTriedSeeds = 1000;

/// Empty where the scenario does not fit the kind of mission.
std::optional<World> tryWorld(MissionKind kind, const WorldConfig& config, std::uint64_t seed) {
  try {
    return makeMissionWorld(kind, config, seed);
  } catch (const common::Error&) {
    return std::nullopt;
  }
}

}  // namespace

World makeMissionWorld(MissionKind kind, WorldConfig config, std::uint64_t seed) {
  if (kind == MissionKind::kFlat) {
    config.crossing = false;
    config.ramp_fields = false;
  }
  return makeWorld(config, seed);
}

World restoreMissionWorld(const std::filesystem::path& mission, std::optional<std::uint64_t> seed) {
  common::Config config;
  config.addFile(mission / kScenarioFile);
  const auto scenario = config.read<ArenaSimConfig>("arena_sim");
  const std::filesystem::path truth = mission / "truth" / "objects.csv";
  const std::vector<std::uint8_t> bytes = common::readFile(truth);
  const std::string table(bytes.begin(), bytes.end());
  const std::uint64_t first = seed.value_or(0);
  const std::uint64_t count = seed ? 1 : kTriedSeeds;
  for (std::uint64_t i = 0; i < count; ++i) {
    for (const MissionKind kind : {MissionKind::kRescue, MissionKind::kFlat}) {
      if (auto world = tryWorld(kind, scenario.world, first + i); world && objectTable(*world) == table) {
        return *std::move(world);
      }
    }
  }
  throw common::Error(fmt::format(
      "{}: {} gives other objects; say the mission's own seed, or make it again with this `rubble arena`",
      truth.string(),
      seed ? fmt::format("seed {}", *seed) : fmt::format("every seed below {}", kTriedSeeds)));
}

}  // namespace rubble::arena_sim
