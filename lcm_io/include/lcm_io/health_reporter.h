#pragma once

#include <map>
#include <rubble/health_t.hpp>
#include <string>

#include "common/time.h"
#include "lcm_io/bus.h"
#include "lcm_io/node.h"

namespace rubble::lcm_io {

/// Composes a process's HEALTH from its bus and its node.
class HealthReporter {
 public:
  HealthReporter(std::string process, common::Utime start_utime);

  /// The report for the interval since the last one; resets the bus's latency measurement. A conflict on
  /// the bus makes the level an error, refused messages make it degraded until an interval without.
  rubble::health_t report(Bus& bus, const NodeStatus& status);

 private:
  const std::string process_;
  const common::Utime start_utime_;
  common::Utime last_utime_;
  std::map<std::string, ChannelStats> last_received_;
  std::map<std::string, ChannelStats> last_published_;
};

}  // namespace rubble::lcm_io
