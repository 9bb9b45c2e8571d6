#pragma once

#include <filesystem>
#include <map>
#include <rubble/lidar_pose_t.hpp>
#include <string>

#include "common/trajectory.h"
#include "grid_image.h"
#include "lcm_io/bus.h"

namespace rubble::tools {

/// Keeps what the processes publish and writes it as the result files of `rubble replay`: trajectories as
/// published and final, poses.csv, one map per level.
class Recorder {
 public:
  explicit Recorder(lcm_io::Bus& bus);

  bool empty() const { return lidar_.empty(); }

  /// Throws common::Error naming the file that cannot be written.
  void write(const std::filesystem::path& dir) const;

 private:
  void addPose(const rubble::lidar_pose_t& pose);

  common::Trajectory lidar_;
  std::map<std::int32_t, GridAssembly> levels_;
  std::string poses_csv_;
};

}  // namespace rubble::tools
