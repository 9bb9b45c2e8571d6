#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <optional>
#include <vector>

#include "grid_map.h"
#include "scan_matcher.h"
#include "scan_projector.h"
#include "slam_lidar/grid_slam.h"

namespace rubble::slam_lidar {

/// A longer gap (s) says nothing about how fast the robot is now.
inline constexpr double kMaxCoasting = 0.6;
/// Scans in a map that is still young.
inline constexpr std::uint64_t kYoungMap = 5;
/// A turn that a map of one scan does tell (rad): a cell at 2.5 m.
inline constexpr double kYoungAngle = 0.02;

/// A scan that waits for commitUntil().
struct PendingScan {
  common::Utime utime = 0;
  common::Pose2 T_world_lidar;
  std::vector<RayEnd> rays;
};

/// What a checkpoint holds as plain values, apart from map and pending scans.
struct Tracking {
  std::optional<common::Utime> utime;
  common::Pose2 T_world_lidar;
  common::Pose2 T_world_written;
  std::array<double, 3> twist{};  ///< m/s, m/s, rad/s in the LiDAR's level frame
  double expected_score = 0.0;    ///< running mean of the score
  double search_distance = 0.0;   ///< of the window when lost
  double search_angle = 0.0;
  int lost_scans = 0;
  int unverified = 0;  ///< good matches still needed before scans are written again
  bool lost = false;
  bool write_next = false;  ///< whatever the motion
  bool stands = true;       ///< where the map began, T_world_written
};

struct GridSlam::State {
  explicit State(const GridSlamConfig& c) : config(c), map(c), projector(c.scan), matcher(c) {}

  GridSlamConfig config;
  GridMap map;
  ScanProjector projector;
  ScanMatcher matcher;
  ProjectedScan scan;
  Tracking tracking;
  std::deque<PendingScan> pending;

  void checkInput(const ScanInput& input) const;
  double secondsSinceLast(common::Utime utime) const {
    return tracking.utime ? common::secondsFromUtime(utime - *tracking.utime) : 0.0;
  }
  common::Pose2 coast(double dt) const {
    const double t = std::min(dt, kMaxCoasting);
    return tracking.T_world_lidar *
           common::Pose2{tracking.twist[0] * t, tracking.twist[1] * t, tracking.twist[2] * t};
  }
  /// Velocity (m/s, m/s, rad/s) over the scan's sweep: the prior's own where there is one.
  Eigen::Vector3d sweepTwist(const std::optional<MotionPrior>& prior, double dt) const {
    if (!prior || !(dt > 0.0)) {
      return {tracking.twist[0], tracking.twist[1], tracking.twist[2]};
    }
    const common::Pose2& T = prior->T_previous_now;
    return Eigen::Vector3d(T.x, T.y, T.yaw) / dt;
  }
  void loseTrack() {
    if (!tracking.lost) {
      tracking.lost = true;
      tracking.lost_scans = 0;
      tracking.search_distance = config.search.wide_distance;
      tracking.search_angle = config.search.wide_angle;
    }
    tracking.twist = {};
    tracking.stands = false;
  }
  void followPrior(const common::Pose2& T_world_lidar, const Eigen::Vector3d& twist) {
    tracking.T_world_lidar = T_world_lidar;
    tracking.twist = {twist.x(), twist.y(), twist.z()};
    tracking.expected_score = 1.0;
    tracking.lost = false;
    tracking.stands = false;
  }
  void moveTo(const common::Pose2& T_world_lidar, double dt, const Eigen::Matrix3d& H);
  /// While the map is of a few scans only, a low score says little and every scan is wanted.
  bool young() const { return map.revision() < kYoungMap; }
  /// In a map of one scan a wall is one row of cells, and a match is as good anywhere across them: until it
  /// finds the robot farther away than about a cell's diagonal, the robot stands where the map began. Several
  /// scans from there smear the row, which tells where in it the wall is. Call it after every match.
  void watchStanding() {
    const common::Pose2 moved = tracking.T_world_written.inverse() * tracking.T_world_lidar;
    tracking.stands = tracking.stands && moved.translation().norm() <= 1.5 * map.finest().cellSize() &&
                      std::abs(moved.yaw) <= kYoungAngle;
    if (tracking.stands) {
      tracking.twist = {};
    }
    if (tracking.stands && !young()) {
      tracking.T_world_lidar = tracking.T_world_written;
      tracking.stands = false;
    }
  }
  /// The pose as it is told and written.
  const common::Pose2& pose() const {
    return tracking.stands && !map.empty() ? tracking.T_world_written : tracking.T_world_lidar;
  }
  ScanMatch track(const ScanInput& input, const common::Pose2& T_world_predicted, double dt);
  ScanMatch searchLost(const common::Pose2& T_world_predicted);
  void match(const ScanInput& input, const common::Pose2& T_world_predicted, double dt, ScanResult& result);
  void writeIfDue(const ScanInput& input, ScanResult& result);
};

}  // namespace rubble::slam_lidar
