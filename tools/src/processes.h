#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/config.h"
#include "lcm_io/replay_hub.h"

namespace rubble::tools {

/// The processes with an algorithm on one bus, in one thread, in the messages' time: what `rubble replay` and
/// the arena's closed loop run.
class Processes {
 public:
  /// `names`: which of slam_mono, recognizer, slam_lidar, fusion; empty: all. Throws common::Error for
  /// another name.
  Processes(const std::vector<std::string>& names, const common::Config& config);
  ~Processes();

  /// A further end of their bus; lives as long as this.
  lcm_io::Bus& endpoint() { return hub_.endpoint(); }

  /// Time passes until the message comes, then all handle it and what they publish meanwhile.
  void feed(const lcm_io::RawMessage& message);
  /// Nothing more will come: what is held back goes out.
  void finish();

  /// health.json and timing.json; after finish(). Throws common::Error.
  void writeReports(const std::filesystem::path& dir) const;

 private:
  struct Process;

  void advance();

  lcm_io::ReplayHub hub_;
  std::vector<std::unique_ptr<Process>> processes_;
  std::optional<common::Utime> start_;
};

}  // namespace rubble::tools
