#pragma once

#include <filesystem>
#include <optional>
#include <rubble/stabilizer_command_t.hpp>

#include "common/config.h"
#include "processes.h"
#include "recorder.h"

namespace rubble::tools {

/// The robot's processes while the arena runs, each message's computing done in no time: what they command
/// moves the plate under the LiDAR.
class ClosedLoop {
 public:
  explicit ClosedLoop(const common::Config& config);

  /// The last command to the plate since the last message, if any.
  std::optional<rubble::stabilizer_command_t> handle(const lcm_io::RawMessage& message);

  /// Ends the processes and writes the files of `rubble replay`. Throws common::Error.
  void write(const std::filesystem::path& dir);

 private:
  Processes processes_;
  Recorder recorder_;
  std::optional<rubble::stabilizer_command_t> command_;
};

}  // namespace rubble::tools
