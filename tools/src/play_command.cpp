#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <memory>
#include <rubble/health_t.hpp>
#include <set>
#include <string>
#include <vector>

#include "command.h"
#include "common/error.h"
#include "lcm_io/channels.h"
#include "lcm_io/lcm_bus.h"
#include "play.h"
#include "stop_signal.h"

namespace rubble::tools {

namespace {

constexpr std::chrono::seconds kLongestWait{30};

struct PlayOptions {
  std::string log;
  double speed = 1.0;
  std::string lcm_url = lcm_io::kDefaultLcmUrl;
  std::vector<std::string> wait_for;
};

/// Returns when every process named has been heard in HEALTH; false when a signal came first.
bool waitForProcesses(lcm_io::Bus& bus, const std::vector<std::string>& names, StopSignal& stop) {
  // Shared with the handler, which the bus keeps.
  const auto missing = std::make_shared<std::set<std::string>>(names.begin(), names.end());
  bus.subscribe<rubble::health_t>(lcm_io::channel::kHealth, [missing](const rubble::health_t& health) {
    missing->erase(health.process);
  });
  const auto deadline = std::chrono::steady_clock::now() + kLongestWait;
  while (!missing->empty()) {
    bus.dispatch(std::chrono::milliseconds(50));
    if (stop.waitUntil(std::chrono::steady_clock::now())) {
      return false;
    }
    if (std::chrono::steady_clock::now() > deadline) {
      throw common::Error(
          fmt::format("--wait-for {}: no HEALTH from it for {} s; is it running on the same --lcm-url?",
                      fmt::join(*missing, ","), kLongestWait.count()));
    }
  }
  return true;
}

void play(const PlayOptions& options) {
  StopSignal stop;
  lcm_io::LcmBus bus(options.lcm_url, "play");
  if (!options.wait_for.empty() && !waitForProcesses(bus, options.wait_for, stop)) {
    return;
  }
  const PlayResult result =
      playLog(options.log, options.speed,
              {[&](lcm_io::LogEvent& event) { bus.publishRaw(event.channel, event.data); },
               [&](std::chrono::steady_clock::time_point deadline) { return stop.waitUntil(deadline); }});
  std::int64_t refused = 0;
  for (const auto& [channel, stats] : bus.published()) {
    refused += stats.dropped;
  }
  fmt::print("{} {} messages, held back {} of channels that are no source\n",
             result.stopped ? "stopped after" : "played", result.played, result.held_back);
  if (refused > 0) {
    throw common::Error(
        fmt::format("{} messages could not be sent on {}; see `rubble doctor`", refused, options.lcm_url));
  }
}

}  // namespace

void addPlayCommand(CLI::App& app) {
  const auto options = std::make_shared<PlayOptions>();
  CLI::App* command = app.add_subcommand("play", "Publish the source channels of an LCM log at its own pace");
  command->add_option("LOG", options->log, "LCM log to play")->required();
  command
      ->add_option("--speed", options->speed,
                   "Times the log's pace; 0: as fast as possible (UDP may lose some)")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  command->add_option("--lcm-url", options->lcm_url, "The bus")->capture_default_str();
  command
      ->add_option("--wait-for", options->wait_for,
                   "Processes whose HEALTH must be heard first, e.g. slam_lidar")
      ->delimiter(',');
  command->footer("Example:\n  rubble play mission.lcm --speed 2\n");
  command->callback([options] { play(*options); });
}

}  // namespace rubble::tools
