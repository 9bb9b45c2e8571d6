#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>

#include "lcm_io/log_file.h"

namespace rubble::tools {

/// How playLog meets the world.
struct PlaySink {
  std::function<void(lcm_io::LogEvent&)> publish;
  /// Waits until the deadline; true: stop now.
  std::function<bool(std::chrono::steady_clock::time_point)> wait_until;
};

struct PlayResult {
  std::int64_t played = 0;
  std::int64_t held_back = 0;  // of derived, command and unlisted channels
  bool stopped = false;
};

/// Plays the source channels of an LCM log at the log's pace times `speed`; 0: as fast as possible. Each
/// message has its own deadline counted from the first, so that no delay adds up. Throws Error.
PlayResult playLog(const std::filesystem::path& log, double speed, const PlaySink& sink);

}  // namespace rubble::tools
