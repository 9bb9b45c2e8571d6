#pragma once

#include <optional>

#include "common/geometry.h"
#include "common/history.h"
#include "common/robot_config.h"
#include "common/time.h"
#include "slam_lidar/grid_slam.h"

namespace rubble::slam_lidar {

/// What the other sensors say about a scan: the LiDAR's tilt from the plate and the body, and its motion
/// since the last scan from odometry or, while nothing is matched (M), from the fused pose.
class ScanContext {
 public:
  struct Tilt {
    Attitude attitude;
    bool extrapolated = false;
  };

  explicit ScanContext(const common::RobotConfig& robot) : robot_(robot) {}

  /// Plate angles (rad) as measured. Throws common::Error when not finite.
  void addPlate(common::Utime utime, double roll, double pitch);
  /// T_world_body as fused: its tilt, its height, and its motion while nothing is matched. Neither position
  /// in the plane nor heading may leak into a match.
  void addBody(common::Utime utime, const common::Pose3& T_world_body);
  void addOdometry(common::Utime utime, const common::Pose3& T_odom_body);

  /// True when everything that is alive has arrived for a sweep from `first` to `last`.
  bool complete(common::Utime first, common::Utime last) const;

  /// Roll and pitch of the LiDAR in the gravity-level frame. A signal that never came is level; one that does
  /// not reach `utime` keeps its last value.
  Tilt tiltAt(common::Utime utime) const;

  /// Where the LiDAR is by the fused pose: for a new level's grid, which has nothing yet to match with. Empty
  /// where the pose does not reach `utime`.
  std::optional<common::Pose2> fusedPose(common::Utime utime) const;

  /// m, over where the LiDAR is at the start; nobody told: 0.
  double heightAt(common::Utime utime) const;

  enum class PriorSource { kOdometry, kFusedPose };
  /// The LiDAR's motion in the level plane since the last call; empty when the source does not cover both
  /// ends.
  std::optional<MotionPrior> takePrior(common::Utime utime, PriorSource source);

 private:
  /// With the plate as it stood.
  common::Pose3 T_body_lidar(common::Utime utime) const;

  const common::RobotConfig robot_;
  common::History<Eigen::Vector2d> plate_;   // roll, pitch of the plate on the body
  common::History<common::Pose3> body_;      // T_world_body
  common::History<common::Pose3> odometry_;  // T_odom_body
  std::optional<common::Pose3> T_odom_lidar_last_;
  std::optional<common::Pose2> T_world_lidar_last_;  // As fused.
};

}  // namespace rubble::slam_lidar
