#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "common/config.h"
#include "lcm_io/bus.h"
#include "lcm_io/node.h"
#include "lcm_io/stage_times.h"

namespace rubble::lcm_io {

/// What runProcess hands to the factory of the node.
struct ProcessContext {
  Bus& bus;
  const common::Config& config;
  /// Where the process keeps what must survive it; empty: nothing is kept.
  std::filesystem::path state_dir;
  /// Where replay wants stage times; null live.
  StageTimes* times = nullptr;
  /// The bus runs in real time: work may go to threads. Else (replay, a log as the bus) it waits for the
  /// node.
  bool live = false;
};

struct ProcessDescription {
  /// Component name: section of the configuration, name in HEALTH and in the channel table.
  const char* name;
  /// One sentence for --help.
  const char* purpose;
  std::function<std::unique_ptr<Node>(const ProcessContext&)> make_node;
  /// The effective configuration as commented YAML, for --print-config.
  std::function<std::string(const common::Config&)> describe_config;
};

/// The whole main of a Rubble process: arguments, configuration, host checks, the loop over the bus,
/// HEALTH at 1 Hz, systemd notification and watchdog, a clean end on SIGTERM (drains what arrived).
/// Returns the exit status: 0 done, 1 failed with one line on stderr, 2 usage.
int runProcess(int argc, char** argv, const ProcessDescription& description);

}  // namespace rubble::lcm_io
