#pragma once

#include <vector>

#include "lcm_io/bus.h"

namespace rubble::ops_console {

/// Where AsyncWriter's thread puts the messages. Both calls may block for as long as the disk does.
class LogSink {
 public:
  virtual ~LogSink() = default;

  /// Takes the whole batch, so that it survives the process, or throws common::Error and takes nothing.
  virtual void write(const std::vector<lcm_io::RawMessage>& batch) = 0;
  /// Makes all that was taken survive power loss. Throws common::Error.
  virtual void sync() = 0;
};

}  // namespace rubble::ops_console
