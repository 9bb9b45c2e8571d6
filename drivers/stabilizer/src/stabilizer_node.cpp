#include "stabilizer_node.h"

#include <fmt/format.h>

#include <algorithm>
#include <rubble/stabilizer_command_t.hpp>
#include <rubble/stabilizer_t.hpp>
#include <utility>

#include "common/error.h"
#include "device/socket_can.h"
#include "lcm_io/channels.h"
#include "stabilizer_config.h"

namespace rubble::stabilizer {

namespace {

using Level = lcm_io::NodeStatus::Level;

constexpr std::array kNames = {"roll", "pitch"};

void add(lcm_io::NodeStatus& status, Level level, const std::string& text) {
  status.level = std::max(status.level, level);
  status.detail += (status.detail.empty() ? "" : "; ") + text;
}

}  // namespace

StabilizerNode::StabilizerNode(lcm_io::Bus& bus, const StabilizerDriver::Options& options,
                               const std::string& interface, OpenCanPort open)
    : bus_(bus),
      interface_(interface),
      nodes_{options.pair.axes[0].drive.setup.node, options.pair.axes[1].drive.setup.node},
      driver_(options, std::move(open), [this] { bus_.wake(); }) {
  bus.subscribe<rubble::stabilizer_command_t>(
      lcm_io::channel::kStabilizerCommand, [this](const auto& command) {
        driver_.command({.utime = command.utime,
                         .valid_until = command.valid_until_utime,
                         .angles = {command.roll, command.pitch},
                         .rates = {command.roll_rate, command.pitch_rate}});
      });
}

void StabilizerNode::advance(common::Utime /*now*/) {
  while (const auto reading = driver_.takeReading()) {
    rubble::stabilizer_t message{};
    message.utime = reading->utime;
    message.roll = reading->angles[0];
    message.pitch = reading->angles[1];
    message.roll_rate = reading->rates[0];
    message.pitch_rate = reading->rates[1];
    message.command_utime = reading->command_utime;
    bus_.publish(lcm_io::channel::kStabilizer, message);
  }
}

lcm_io::NodeStatus StabilizerNode::status() const {
  const StabilizerDriver::Status driver = driver_.status();
  const PairStatus& pair = driver.pair;
  lcm_io::NodeStatus status;
  status.counters = {{"readings", pair.readings},
                     {"readings_dropped", driver.readings_dropped},
                     {"cycles_missed", driver.cycles_missed},
                     {"commands", pair.commands},
                     {"commands_refused", pair.commands_refused},
                     {"frames_unsent", driver.frames_unsent},
                     {"bus_errors", pair.bus_errors},
                     {"interface_failures", driver.port_failures}};
  status.state = !pair.enabled ? "starting" : pair.following ? "following" : "holding";
  // What works again is news only while nothing is broken.
  const bool is_broken =
      !driver.open || std::any_of(pair.drives.begin(), pair.drives.end(), [](const DriveStatus& drive) {
        return drive.problem.kind != Problem::Kind::kNone && !drive.solved;
      });
  if (!driver.port_problem.empty() && (!driver.open || !is_broken)) {
    add(status, driver.open ? Level::kDegraded : Level::kError,
        fmt::format("CAN interface {} {}{}", interface_, driver.open ? "works again; before: it " : "",
                    driver.port_problem));
    status.state = driver.open ? status.state : "failed";
  }
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    const DriveStatus& drive = pair.drives[i];
    const std::string name = fmt::format("{} drive (node {})", kNames[i], nodes_[i]);
    status.counters[fmt::format("{}_failures", kNames[i])] = drive.failures;
    status.counters[fmt::format("{}_fault_resets", kNames[i])] = drive.fault_resets;
    status.counters[fmt::format("{}_emergencies", kNames[i])] = drive.emergencies;
    status.counters[fmt::format("{}_unexpected", kNames[i])] = drive.unexpected;
    if (driver.open && drive.problem.kind != Problem::Kind::kNone && !(drive.solved && is_broken)) {
      add(status, drive.solved ? Level::kDegraded : Level::kError,
          fmt::format("{} {}{}", name, drive.solved ? "works again; before: it " : "",
                      describe(drive.problem)));
      if (!drive.solved && !pair.enabled) {
        status.state = "failed";
      }
    }
    if (pair.limited[i]) {
      add(status, Level::kDegraded,
          fmt::format("the {} that is wanted is out of range: it holds at stabilizer.{}'s limit", kNames[i],
                      kNames[i]));
    }
  }
  if (pair.bus_error != BusError::kNone) {
    add(status, Level::kDegraded, fmt::format("CAN interface {}: {}", interface_, describe(pair.bus_error)));
  }
  if (status.detail.empty() && !pair.enabled) {
    add(status, Level::kDegraded, "the drives are being set up");
  } else if (driver.open && pair.enabled && !pair.following) {
    add(status, Level::kDegraded, "it holds: no STABILIZER_COMMAND is valid; does rubble-fusion run?");
  }
  return status;
}

std::unique_ptr<lcm_io::Node> makeStabilizerNode(const lcm_io::ProcessContext& context) {
  if (!context.live) {
    throw common::Error("rubble-stabilizer drives a plate and reads no log; give a live --lcm-url");
  }
  const auto config = context.config.read<StabilizerConfig>("stabilizer");
  return std::make_unique<StabilizerNode>(
      context.bus, driverOptions(config), config.interface,
      [interface = config.interface, nodes = std::array{config.roll.node, config.pitch.node}] {
        return openSocketCan(interface, nodes);
      });
}

}  // namespace rubble::stabilizer
