#include "lidar_node.h"

#include <fmt/format.h>

#include <utility>

#include "lcm_io/channels.h"
#include "lidar_config.h"

namespace rubble::lidar {

namespace {

using Level = lcm_io::NodeStatus::Level;
using State = LidarReader::State;

LidarReader::Clock::duration duration(double seconds) {
  return std::chrono::duration_cast<LidarReader::Clock::duration>(std::chrono::duration<double>(seconds));
}

}  // namespace

LidarNode::LidarNode(lcm_io::Bus& bus, LidarReader::Options options)
    : bus_(bus), address_(options.address.text), reader_(std::move(options), [this] { bus_.wake(); }) {}

void LidarNode::advance(common::Utime /*now*/) {
  while (reader_.takeScan(scan_)) {
    message_.utime = scan_.utime;
    message_.rad0 = scan_.rad0;
    message_.radstep = scan_.radstep;
    // Swapped, so that the memory goes round.
    message_.ranges.swap(scan_.ranges);
    message_.intensities.swap(scan_.intensities);
    message_.nranges = static_cast<std::int32_t>(message_.ranges.size());
    message_.nintensities = static_cast<std::int32_t>(message_.intensities.size());
    bus_.publish(lcm_io::channel::kScan, message_);
  }
}

lcm_io::NodeStatus LidarNode::status() const {
  const LidarReader::Status reader = reader_.status();
  lcm_io::NodeStatus status;
  status.counters = {{"scans", reader.counters.scans},
                     {"scans_lost", reader.counters.scans_lost},
                     {"scans_damaged", reader.counters.scans_damaged},
                     {"scans_dropped", reader.dropped},
                     {"garbage_bytes", reader.counters.garbage_bytes},
                     {"unexpected_answers", reader.counters.unexpected},
                     {"clock_jumps", reader.counters.clock_jumps},
                     {"failures", reader.failures}};
  switch (reader.state) {
    case State::kConnecting:
      status.level = Level::kDegraded;
      status.state = "connecting";
      status.detail = fmt::format("LiDAR {} has sent no scan yet", address_);
      break;
    case State::kScanning:
      status.state = "scanning";
      if (!reader.warning.empty()) {
        status.level = Level::kDegraded;
        status.detail = fmt::format("LiDAR {}: {}", address_, reader.warning);
      }
      break;
    case State::kVerifying:
      status.level = Level::kDegraded;
      status.state = "verifying";
      status.detail = fmt::format("LiDAR {} has stopped to check itself; wait", address_);
      break;
    case State::kFailed:
      status.level = Level::kError;
      status.state = "failed";
      status.detail = reader.problem;
      break;
  }
  return status;
}

std::unique_ptr<lcm_io::Node> makeLidarNode(const lcm_io::ProcessContext& context) {
  const auto config = context.config.read<LidarConfig>("lidar");
  return std::make_unique<LidarNode>(context.bus,
                                     LidarReader::Options{.address = parseAddress(config.connection),
                                                          .baud = config.baud,
                                                          .wish = {.first_angle = config.first_angle,
                                                                   .last_angle = config.last_angle,
                                                                   .cluster = config.cluster,
                                                                   .skip = config.skip,
                                                                   .intensities = config.intensities},
                                                          .silence = duration(config.silence_timeout),
                                                          .first_pause = duration(config.first_pause),
                                                          .longest_pause = duration(config.longest_pause)});
}

}  // namespace rubble::lidar
