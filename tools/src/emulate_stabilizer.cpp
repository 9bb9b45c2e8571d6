#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "command.h"
#include "common/error.h"
#include "device/socket_can.h"
#include "stabilizer_emulator/stabilizer_emulator.h"
#include "stop_signal.h"
#include "timed_word.h"

namespace rubble::tools {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kTick{50};
constexpr std::array<std::string_view, 2> kAxes = {"roll", "pitch"};

struct Options {
  std::string interface = "can0";
  stabilizer::EmulatedModel model;
  std::vector<std::string> faults;
};

struct TimedFault {
  std::size_t axis = 0;
  stabilizer::DriveFault fault;
  Clock::duration after;
};

/// `AXIS:KIND@SECONDS`
TimedFault parseFault(const std::string& text) {
  const TimedWord timed = parseTimedWord(text, "roll:fault@5");
  const std::size_t colon = std::min(timed.word.find(':'), timed.word.size());
  const auto* const axis = std::find(kAxes.begin(), kAxes.end(), timed.word.substr(0, colon));
  if (axis == kAxes.end() || colon == timed.word.size()) {
    throw common::Error(fmt::format("--fault {}: write AXIS:KIND@SECONDS, e.g. roll:fault@5", text));
  }
  try {
    return {static_cast<std::size_t>(axis - kAxes.begin()),
            stabilizer::parseDriveFault(timed.word.substr(colon + 1)), timed.after};
  } catch (const common::Error& e) {
    throw common::Error(fmt::format("--fault {}: {}", text, e.what()));
  }
}

void emulateStabilizer(const Options& options) {
  std::vector<TimedFault> faults;
  for (const std::string& text : options.faults) {
    faults.push_back(parseFault(text));
  }
  StopSignal stop;
  try {
    stabilizer::StabilizerEmulator emulator(options.model, stabilizer::openSocketCan(options.interface, {}));
    fmt::print("stabiliser on {}: roll is node {}, pitch is node {}\n", options.interface,
               options.model.nodes[0], options.model.nodes[1]);
    std::fflush(stdout);
    const Clock::time_point start = Clock::now();
    while (!stop.waitUntil(Clock::now() + kTick)) {
      emulator.check();
      std::erase_if(faults, [&](const TimedFault& f) {
        const bool due = Clock::now() - start >= f.after;
        if (due) {
          emulator.inject(f.axis, f.fault);
        }
        return due;
      });
    }
    fmt::print("it stands at {:.3f} {:.3f} rad\n", emulator.angle(0), emulator.angle(1));
  } catch (const common::Error& e) {
    throw common::Error(fmt::format("CAN interface {} {}", options.interface, e.what()));
  }
}

}  // namespace

void addEmulateStabilizer(CLI::App& emulate) {
  const auto options = std::make_shared<Options>();
  CLI::App* command = emulate.add_subcommand(
      "stabilizer", "The LiDAR stabiliser's two CiA 402 drives on a CAN bus; for rubble-stabilizer");
  command->add_option("--interface", options->interface, "Of SocketCAN, e.g. can0 or vcan0")
      ->capture_default_str();
  command->add_option("--roll-node", options->model.nodes[0], "CANopen node id")
      ->check(CLI::Range(1, 127))
      ->capture_default_str();
  command->add_option("--pitch-node", options->model.nodes[1], "CANopen node id")
      ->check(CLI::Range(1, 127))
      ->capture_default_str();
  command
      ->add_option(
          "--fault", options->faults,
          "AXIS:KIND@SECONDS from the start: roll or pitch; fault, lasting-fault, silence, stuck, free, "
          "wrong-sdo, sdo-abort, off or on; several times")
      ->allow_extra_args(false);
  command->footer(
      "Example:\n  rubble emulate stabilizer --interface vcan0 --fault roll:fault@5 &\n"
      "  rubble-stabilizer --set stabilizer.interface=vcan0\n");
  command->callback([options] { emulateStabilizer(*options); });
}

}  // namespace rubble::tools
