#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/config.h"

namespace rubble::tools {

struct ReplayOptions {
  std::filesystem::path log;
  std::filesystem::path out_dir;
  /// Component names; empty: every component that has an algorithm.
  std::vector<std::string> only;
  common::Config config;
};

/// Runs the processes' nodes over a log's source channels in one thread, in the log's time, and writes
/// trajectories, maps, health.json and timing.json into out_dir. Two runs write the same bytes (timing.json
/// aside). Throws common::Error for a log that cannot be read or a component that does not exist.
void replay(const ReplayOptions& options);

}  // namespace rubble::tools
