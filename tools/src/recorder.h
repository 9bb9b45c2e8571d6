#pragma once

#include <filesystem>
#include <map>
#include <rubble/lidar_pose_t.hpp>
#include <rubble/mono_pose_t.hpp>
#include <rubble/objects_t.hpp>
#include <rubble/robot_pose_t.hpp>
#include <string>

#include "common/trajectory.h"
#include "grid_image.h"
#include "lcm_io/bus.h"
#include "mono_path.h"

namespace rubble::tools {

/// Keeps what the processes publish and writes it as the result files of `rubble replay`: trajectories as
/// published and final, poses.csv, objects.csv, one map per level.
class Recorder {
 public:
  explicit Recorder(lcm_io::Bus& bus);

  bool empty() const { return lidar_.empty() && fused_.empty() && mono_pictures_ == 0; }

  /// Says on stderr which pictures have no place in the final monocular trajectory: those of smaller maps,
  /// and those whose keyframe was lost on the bus. Throws common::Error naming the file that cannot be
  /// written.
  void write(const std::filesystem::path& dir) const;

 private:
  void addPose(const rubble::lidar_pose_t& pose);
  void addPose(const rubble::mono_pose_t& pose);
  void addPose(const rubble::robot_pose_t& pose);
  void writeObjects(const std::filesystem::path& path) const;
  void writeMono(const std::filesystem::path& dir) const;

  common::Trajectory lidar_;
  common::Trajectory mono_;   // Of tracked pictures.
  common::Trajectory fused_;  // T_world_body
  std::int64_t mono_pictures_ = 0;
  MonoPath mono_path_;
  struct Level {
    GridAssembly grid;
    common::Trajectory T_world_lidar;
  };
  std::map<std::int32_t, Level> levels_;
  rubble::objects_t objects_;  // As last told.
  std::string poses_csv_;
  std::string covariance_csv_;
};

}  // namespace rubble::tools
