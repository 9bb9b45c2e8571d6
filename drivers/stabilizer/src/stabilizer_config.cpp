#include "stabilizer_config.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/error.h"

namespace rubble::stabilizer {

namespace {

double incrementsPerRad(const AxisConfig& axis) { return axis.counts_per_turn * axis.gear / (2.0 * M_PI); }

void check(const AxisConfig& axis, const char* name) {
  if (axis.lowest >= axis.highest) {
    throw common::Error(fmt::format("stabilizer.{}.lowest = {} is not below stabilizer.{}.highest = {}", name,
                                    axis.lowest, name, axis.highest));
  }
  const double farthest =
      std::max(std::abs(axis.lowest - axis.zero_offset), std::abs(axis.highest - axis.zero_offset));
  if (farthest * incrementsPerRad(axis) > std::numeric_limits<std::int32_t>::max()) {
    throw common::Error(
        fmt::format("stabilizer.{}.counts_per_turn * gear = {} leaves the drive's 32 bits within the range",
                    name, axis.counts_per_turn * axis.gear));
  }
}

Tick ticks(double seconds) { return common::utimeFromSeconds(seconds); }

StabilizerDriver::Clock::duration duration(double seconds) {
  return std::chrono::duration_cast<StabilizerDriver::Clock::duration>(
      std::chrono::duration<double>(seconds));
}

AxisOptions axisOptions(const StabilizerConfig& config, const AxisConfig& axis) {
  const double increments = incrementsPerRad(axis);
  const auto whole = [](double value) {
    constexpr double kMost = std::numeric_limits<std::uint32_t>::max();
    return static_cast<std::uint32_t>(std::clamp(std::round(value), 1.0, kMost));
  };
  return {.drive = {.setup = {.node = axis.node,
                              .mode = config.mode == "csp" ? Mode::kCyclicSynchronousPosition
                                                           : Mode::kProfilePosition,
                              .cycle_ms = config.cycle_ms,
                              .heartbeat_ms = config.heartbeat_ms,
                              .profile_velocity = whole(axis.rate * increments),
                              .profile_acceleration = whole(config.acceleration * increments)},
                    .heartbeat_timeout = ticks(config.heartbeat_timeout),
                    .fault_resets = config.fault_resets,
                    .first_pause = ticks(config.first_pause),
                    .longest_pause = ticks(config.longest_pause),
                    .following_error = std::llround(config.following_error * increments)},
          .rad_per_increment = (axis.reversed ? -1.0 : 1.0) / increments,
          .zero_offset = axis.zero_offset};
}

}  // namespace

void visit(common::ConfigSection& section, AxisConfig& config) {
  section.integer("node", config.node, "", 1, 127, "CANopen node id of the drive");
  section.integer("counts_per_turn", config.counts_per_turn, "", 1, 1 << 24,
                  "increments of one turn of the motor");
  section.number("gear", config.gear, "", 0.01, 10'000, "turns of the motor for one of the plate");
  section.flag("reversed", config.reversed, "the drive counts up as the plate's angle goes down");
  section.number("zero_offset", config.zero_offset, "rad", -3.2, 3.2,
                 "the plate's angle where the drive counts 0");
  section.number("lowest", config.lowest, "rad", -1.5, 1.5, "angle of the plate");
  section.number("highest", config.highest, "rad", -1.5, 1.5, "angle of the plate");
  section.number("rate", config.rate, "rad/s", 0.01, 50, "fastest turn of the plate");
}

void visit(common::ConfigSection& section, StabilizerConfig& config) {
  section.text("interface", config.interface, "of SocketCAN, as `ip link` shows it");
  section.choice("mode", config.mode, {"csp", "pp"},
                 "of operation: cyclic synchronous position, or profile position for drives without it");
  section.integer("cycle_ms", config.cycle_ms, "ms", 2, 50, "between two set-points and readings");
  section.integer("heartbeat_ms", config.heartbeat_ms, "ms", 10, 10'000, "between two heartbeats of a drive");
  section.number("heartbeat_timeout", config.heartbeat_timeout, "s", 0.02, 60,
                 "without a heartbeat after which a drive counts as lost");
  section.number("acceleration", config.acceleration, "rad/s^2", 0.1, 10'000, "of the plate, in mode pp");
  section.number("following_error", config.following_error, "rad", 0.001, 3,
                 "between set-point and plate for half a second that is reported");
  section.integer("fault_resets", config.fault_resets, "", 0, 1000,
                  "in a row before a drive's fault counts as lasting");
  section.number("first_pause", config.first_pause, "s", 0.01, 60,
                 "before a fault is reset, or drive or interface are tried again; doubles from try to try");
  section.number("longest_pause", config.longest_pause, "s", 0.01, 600, "between two tries");
  visit(section.section("roll", "the servo that turns the plate about body x"), config.roll);
  visit(section.section("pitch", "the servo that turns it about the rolled y"), config.pitch);
  check(config.roll, "roll");
  check(config.pitch, "pitch");
  if (config.roll.node == config.pitch.node) {
    throw common::Error(
        fmt::format("stabilizer.roll.node and stabilizer.pitch.node are both {}", config.roll.node));
  }
  if (config.interface.empty() || config.interface.size() > 15) {
    throw common::Error(fmt::format("stabilizer.interface = `{}` is no name of an interface; write e.g. can0",
                                    config.interface));
  }
  if (1e-3 * config.heartbeat_ms >= config.heartbeat_timeout) {
    throw common::Error(
        fmt::format("stabilizer.heartbeat_timeout = {} s is not above stabilizer.heartbeat_ms = {}",
                    config.heartbeat_timeout, config.heartbeat_ms));
  }
  if (config.first_pause > config.longest_pause) {
    throw common::Error(fmt::format("stabilizer.first_pause = {} is above stabilizer.longest_pause = {}",
                                    config.first_pause, config.longest_pause));
  }
}

StabilizerDriver::Options driverOptions(const StabilizerConfig& config) {
  return {.pair = {.axes = {axisOptions(config, config.roll), axisOptions(config, config.pitch)},
                   .limits = {.lowest = {config.roll.lowest, config.pitch.lowest},
                              .highest = {config.roll.highest, config.pitch.highest},
                              .rate = {config.roll.rate, config.pitch.rate}}},
          .cycle = std::chrono::milliseconds(config.cycle_ms),
          .first_pause = duration(config.first_pause),
          .longest_pause = duration(config.longest_pause)};
}

}  // namespace rubble::stabilizer
