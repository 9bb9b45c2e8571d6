#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "command.h"
#include "common/error.h"
#include "lcm_io/lcm_bus.h"
#include "play.h"
#include "stop_signal.h"

namespace rubble::tools {

namespace {

struct Options {
  std::string log;
  double speed = 1.0;
  std::string lcm_url = lcm_io::kDefaultLcmUrl;
};

void play(const Options& options) {
  StopSignal stop;
  lcm_io::LcmBus bus(options.lcm_url, "play");
  const PlayResult result =
      playLog(options.log, options.speed,
              {[&](lcm_io::LogEvent& event) { bus.publishRaw(event.channel, std::move(event.data)); },
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
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("play", "Publish the source channels of an LCM log at its own pace");
  command->add_option("LOG", options->log, "LCM log to play")->required();
  command
      ->add_option("--speed", options->speed,
                   "Times the log's pace; 0: as fast as possible (UDP may lose some)")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  command->add_option("--lcm-url", options->lcm_url, "The bus")->capture_default_str();
  command->footer("Example:\n  rubble play mission.lcm --speed 2\n");
  command->callback([options] { play(*options); });
}

}  // namespace rubble::tools
