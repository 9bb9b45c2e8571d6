#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "command.h"
#include "common/error.h"
#include "lidar_emulator/lidar_emulator.h"
#include "scan_log.h"
#include "stop_signal.h"
#include "timed_word.h"

namespace rubble::tools {

namespace {

using Clock = std::chrono::steady_clock;

constexpr int kHokuyoPort = 10940;
constexpr std::chrono::milliseconds kTick{50};

struct EmulateOptions {
  std::string log;
  lidar::LidarEmulator::Options line{.port = kHokuyoPort};
  bool loop = false;
  std::vector<std::string> faults;
};

struct TimedFault {
  lidar::Fault fault;
  Clock::duration after;
};

TimedFault parseFault(const std::string& text) {
  const TimedWord timed = parseTimedWord(text, "cut@5");
  try {
    return {lidar::parseFault(timed.word), timed.after};
  } catch (const common::Error& e) {
    throw common::Error(fmt::format("--fault {}: {}", text, e.what()));
  }
}

void emulateLidar(const EmulateOptions& options) {
  std::vector<TimedFault> faults;
  for (const std::string& text : options.faults) {
    faults.push_back(parseFault(text));
  }
  StopSignal stop;
  const auto log = std::make_shared<ScanLog>(options.log, options.loop);
  const lidar::EmulatedModel model = log->model();
  lidar::LidarEmulator emulator(options.line, model,
                                [log](lidar::EmulatedScan& scan) { return log->next(scan); });
  fmt::print("LiDAR at {}: {} beams, {:.1f} Hz\n", emulator.address(), model.beams, model.rate);
  std::fflush(stdout);
  const Clock::time_point start = Clock::now();
  while (!emulator.waitForEnd(kTick) && !stop.waitUntil(Clock::now())) {
    std::erase_if(faults, [&](const TimedFault& f) {
      const bool due = Clock::now() - start >= f.after;
      if (due) {
        emulator.inject(f.fault);
      }
      return due;
    });
  }
  fmt::print("sent {} scans\n", emulator.scansSent());
}

}  // namespace

void addEmulateCommand(CLI::App& app) {
  CLI::App* emulate = app.add_subcommand("emulate", "Be a device: what a driver talks to");
  emulate->require_subcommand(1);
  emulate->footer("Example:\n  rubble emulate lidar mission.lcm --loop\n");

  const auto options = std::make_shared<EmulateOptions>();
  CLI::App* command = emulate->add_subcommand(
      "lidar", "A Hokuyo (SCIP 2.0) that sees the scans of an LCM log at their own rate; for rubble-lidar");
  command->add_option("LOG", options->log, "LCM log with SCAN")->required();
  CLI::Option* port =
      command->add_option("--port", options->line.port, "TCP port on this host; 0: any free one")
          ->check(CLI::Range(0, 65535))
          ->capture_default_str();
  command->add_flag("--pty", options->line.pty, "A serial port (pty) instead of TCP")->excludes(port);
  command->add_flag("--loop", options->loop, "Begin anew at the end of the log");
  command
      ->add_option(
          "--fault", options->faults,
          "KIND@SECONDS from the start: cut, checksum, echo, garbage, freeze, malfunction, clock-jump, "
          "clock-reset or clock-wrap; several times")
      ->allow_extra_args(false);
  command->footer(
      "Example:\n  rubble emulate lidar mission.lcm --loop --fault cut@5 &\n"
      "  rubble-lidar --set lidar.connection=tcp://127.0.0.1:10940\n");
  command->callback([options] { emulateLidar(*options); });
  addEmulateStabilizer(*emulate);
}

}  // namespace rubble::tools
