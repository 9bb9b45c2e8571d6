#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "arena_sim/mission.h"
#include "common/config.h"
#include "experiment_report.h"

namespace rubble::tools {

struct ExperimentOptions {
  /// Of every mission; the seed aside.
  arena_sim::MissionOptions mission;
  std::vector<std::uint64_t> seeds;
  std::filesystem::path out_dir;
  common::Config config;
};

/// `1..20`, `7` or `1,4,8..10`, in the order given. Throws common::Error for anything else.
std::vector<std::uint64_t> parseSeeds(const std::string& text);

/// Grid SLAM alone, fusion in each of its modes, and joint less each of its factors on the same arena
/// missions, held against the truth. Monocular SLAM and the recogniser, which hear neither of them, run once
/// per mission. Writes out_dir/seed_N/{mission, grid, lsm, lsm-robust, joint, joint-less-ranges ...} (the log
/// itself stays in the arena's cache) and out_dir/report.md, after every seed anew. Throws common::Error.
void runExperiment(const ExperimentOptions& options);

/// Holds the files of a replay against the truth of its mission (`rubble arena`). With only a planar pose the
/// body is taken to be level. What cannot be scored keeps the worst value.
Score scoreResults(const std::filesystem::path& results, const std::filesystem::path& mission, bool planar);

/// Holds the marks and the monocular path of a replay with fusion against the truth of its mission. Throws
/// common::Error.
RecognitionScore scoreRecognition(const std::filesystem::path& results, const std::filesystem::path& mission,
                                  std::uint64_t seed);

}  // namespace rubble::tools
