#pragma once

#include <chrono>
#include <csignal>

namespace rubble::tools {

/// SIGINT and SIGTERM as something to wait for. While it lives both are blocked in this thread and in those
/// it starts, so make it before any of these.
class StopSignal {
 public:
  StopSignal();
  /// Restores what was before.
  ~StopSignal();
  StopSignal(const StopSignal&) = delete;
  StopSignal& operator=(const StopSignal&) = delete;

  /// Waits until the deadline (at once when it has passed). True when a signal came before it.
  bool waitUntil(std::chrono::steady_clock::time_point deadline);

 private:
  sigset_t signals_{};
  sigset_t before_{};
};

}  // namespace rubble::tools
