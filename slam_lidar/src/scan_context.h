#pragma once

#include <optional>

#include "common/geometry.h"
#include "common/robot_config.h"
#include "common/time.h"
#include "history.h"
#include "slam_lidar/grid_slam.h"

namespace rubble::slam_lidar {

/// What the other sensors say about a scan: the LiDAR's tilt from the plate and the body, and its motion
/// since the last scan from odometry.
class ScanContext {
 public:
  struct Tilt {
    Attitude attitude;
    bool extrapolated = false;
  };

  explicit ScanContext(const common::RobotConfig& robot) : robot_(robot) {}

  /// Plate angles (rad) as measured. Throws common::Error when not finite.
  void addPlate(common::Utime utime, double roll, double pitch);
  /// T_world_body as fused: its tilt alone is kept, no position or heading may leak into the match.
  void addBody(common::Utime utime, const common::Pose3& T_world_body);
  void addOdometry(common::Utime utime, const common::Pose3& T_odom_body);

  /// True when everything that is alive has arrived for a sweep from `first` to `last`.
  bool complete(common::Utime first, common::Utime last) const;

  /// Roll and pitch of the LiDAR in the gravity-level frame. A signal that never came is level; one that does
  /// not reach `utime` keeps its last value.
  Tilt tiltAt(common::Utime utime) const;

  /// The LiDAR's motion since the last call; empty when odometry does not cover both ends.
  std::optional<MotionPrior> takePrior(common::Utime utime);

 private:
  const common::RobotConfig robot_;
  History<Eigen::Vector2d> plate_;   // roll, pitch of the plate on the body
  History<Eigen::Vector2d> body_;    // roll, pitch of the body in the level frame
  History<common::Pose3> odometry_;  // T_odom_body
  std::optional<common::Pose3> T_odom_lidar_last_;
};

}  // namespace rubble::slam_lidar
