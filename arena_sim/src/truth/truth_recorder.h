#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "common/config.h"
#include "common/trajectory.h"
#include "scene/ray_tracer.h"
#include "truth/truth_map.h"
#include "world/world.h"

namespace rubble::arena_sim {

/// Units in visit().
struct TruthConfig {
  double largest_tilt = 0.0523598775598299;  // 3 degrees
  double level_band = 0.25;
};

void visit(common::ConfigSection& section, TruthConfig& config);

/// Whether a planar map can take the scan. H: the LiDAR's plane is level and at its level's height; M: not.
struct LidarState {
  bool is_usable = true;
  std::size_t level = 0;  // The one that is nearest in height.
  double tilt = 0.0;      // rad, of the LiDAR's z axis from the vertical.
  double height = 0.0;    // m, above where it is on the level's floor.
};

/// `floors`: heights (m) of the levels; at least one. `lidar_height`: m, over a floor.
LidarState lidarStateAt(const TruthConfig& config, const common::Pose3& T_world_lidar,
                        std::span<const double> floors, double lidar_height);

/// Collects what is true during a mission and writes it: body.tum, camera.tum, lidar.tum, states.csv,
/// objects.csv, and for every level that was seen in H map_K.pgm and .yaml. Level 0 is the floor the robot
/// starts on, 1 the platform.
class TruthRecorder {
 public:
  /// World and tracer must outlive this. lidar_height: of the LiDAR over a level floor, m.
  TruthRecorder(const TruthConfig& config, const World& world, const RayTracer& tracer, double lidar_height);

  void addPicture(common::Utime utime, const common::Pose3& T_world_body,
                  const common::Pose3& T_world_camera);
  void addScan(common::Utime utime, const common::Pose3& T_world_body, const common::Pose3& T_world_lidar);

  /// Throws common::Error.
  void write(const std::filesystem::path& folder) const;

  /// Of level 0.
  const TruthMap& map() const { return levels_.front().map; }

 private:
  struct Level {
    TruthMap map;
    int scans = 0;  // In H.
  };

  void seeMap(TruthMap& map, const Eigen::Vector3d& p_world_lidar, double yaw) const;

  const TruthConfig config_;
  const World& world_;
  const RayTracer& tracer_;
  const double lidar_height_;
  std::vector<double> floors_;  // m, of the levels.
  std::vector<Level> levels_;
  common::Trajectory body_;
  common::Trajectory camera_;
  common::Trajectory lidar_;
  std::string states_;
};

}  // namespace rubble::arena_sim
