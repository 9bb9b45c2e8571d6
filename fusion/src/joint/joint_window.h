#pragma once

#include <deque>
#include <optional>

#include "common/config.h"
#include "common/time.h"
#include "joint_state.h"

namespace rubble::fusion {

/// Deviations, and which factors are used.
struct JointConfig {
  int window = 20;                  ///< states
  double motion_position = 0.0038;  ///< m per root of a metre
  double motion_rotation = 0.0008;  ///< rad per root of a metre
  double turn_rotation = 0.004;     ///< share of the turn
  double scale_walk = 0.005;        ///< per root of a metre
  double scale_turn = 0.01;         ///< per root of a radian
  bool lidar = true;
  double lidar_position = 0.02;  ///< m, beyond the scan's own
  double lidar_slope = 0.3;      ///< m per rad of the body's tilt, the same
  double lidar_heading = 0.01;   ///< rad
  bool floor = true;
  double floor_height = 0.05;  ///< m, per state
  double floor_tilt = 0.02;    ///< rad, per state
  bool ranges = true;
  double range_scale = 0.02;  ///< of one measurement
  bool clock = true;
};

void visit(common::ConfigSection& section, JointConfig& config);

/// From one state to the next.
struct VisionMotion {
  common::Pose3 T_from_to;  ///< m, at this scale
  double log_scale;
};

/// Grid SLAM's pose at a state's time.
struct LidarFix {
  common::Pose3 T_camera_lidar;
  common::Pose2 T_world_lidar;
  Eigen::Vector3d velocity;    ///< m/s, m/s, rad/s in world
  Eigen::Matrix3d covariance;  ///< of x, y, yaw; positive definite
};

/// What is known at a new state beside vision's motion.
struct JointMeasurements {
  std::optional<LidarFix> lidar;
  std::optional<double> floor;      ///< m: the body is taken to stand on a level floor at this height
  std::optional<double> log_scale;  ///< by the LiDAR's ranges at map points
};

struct JointEstimate {
  JointState state;
  JointMatrix covariance;
};

/// A sliding window of states, joined by vision's motion at a slowly walking scale, held by grid SLAM's
/// poses, the floor and ranges; what leaves the window is marginalised into a prior. Synchronous,
/// deterministic.
class JointWindow {
 public:
  JointWindow(const JointConfig& config, const common::Pose3& T_camera_body);

  /// Begins anew from there.
  void restart(const JointState& state, const JointVector& sigmas);
  bool empty() const { return nodes_.empty(); }

  /// A state after that motion.
  void add(const VisionMotion& motion, const JointMeasurements& measured);
  /// The newest state by all of the window.
  JointEstimate solve();

 private:
  struct Node {
    JointState state;
    std::optional<VisionMotion> motion;  // From the node before.
    JointMeasurements measured;
  };
  struct Belief {
    JointState mean;
    JointMatrix information;
  };

  /// What is known of node `i + 1` from all up to and including `i`, given the same of node `i`.
  Belief passOn(const Belief& belief, std::size_t i) const;
  /// Adds the factors of node `i` alone to H and b of its change.
  void addUnary(std::size_t i, JointMatrix& H, JointVector& b) const;

  const JointConfig config_;
  const common::Pose3 T_camera_body_;
  Belief prior_;  // Of the first node.
  std::deque<Node> nodes_;
};

}  // namespace rubble::fusion
