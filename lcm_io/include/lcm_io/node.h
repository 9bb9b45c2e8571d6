#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "common/time.h"

namespace rubble::lcm_io {

/// How a process is; HEALTH carries it.
struct NodeStatus {
  enum class Level { kOk = 0, kDegraded = 1, kError = 2 };

  Level level = Level::kOk;
  /// One word, e.g. "tracking".
  std::string state;
  /// What is wrong and how to fix it; empty when all is well.
  std::string detail;
  /// Named counts since the start, e.g. "scans_lost".
  std::map<std::string, std::int64_t> counters;
};

/// What a process does between the bus and its algorithm. A node subscribes in its constructor; all
/// calls come from one thread. The same node runs live (runProcess) and in replay (ReplayHub).
class Node {
 public:
  virtual ~Node() = default;

  /// Lets time pass: called after every message, and live at least every 20 ms.
  virtual void advance(common::Utime /*now*/) {}

  /// The last call: nothing more will arrive, what is held back goes out.
  virtual void finish() {}

  virtual NodeStatus status() const = 0;

  /// Which of the node's own threads works no more, in words; empty when all do. systemd's watchdog is fed
  /// only then, so that a process that says so is started again.
  virtual std::string hung() const { return {}; }
};

}  // namespace rubble::lcm_io
