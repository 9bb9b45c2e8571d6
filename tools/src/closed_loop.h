#pragma once

#include <filesystem>

#include "arena_sim/mission.h"
#include "common/config.h"
#include "processes.h"
#include "recorder.h"

namespace rubble::tools {

/// The robot's processes while the arena runs, each message's computing done in no time: what they command
/// moves the plate under the LiDAR, and the robot goes back where they ask for it.
class ClosedLoop {
 public:
  explicit ClosedLoop(const common::Config& config);

  /// What they wanted last since the message before.
  arena_sim::RobotWish handle(const lcm_io::RawMessage& message);

  /// Ends the processes and writes the files of `rubble replay`. Throws common::Error.
  void write(const std::filesystem::path& dir);

 private:
  Processes processes_;
  Recorder recorder_;
  arena_sim::RobotWish wish_;
};

}  // namespace rubble::tools
