#pragma once

#include <cstdint>
#include <optional>

#include "joint/joint_window.h"
#include "plane_state.h"
#include "recent_path.h"

namespace rubble::fusion {

/// What is known where the window begins, beside the pose.
struct JointStart {
  double scale = 1.0;
  double scale_sigma = 1.0;  ///< relative
  double drift = 0.0;        ///< m, deviation of the position
  bool attitude_known = true;
};

/// Runs the joint window along the camera's way: which moments become its states, and what is measured there.
class JointPath {
 public:
  JointPath(const JointConfig& config, const common::Pose3& T_camera_body);

  /// Vision carries the pose and the window holds it.
  bool active() const { return estimate_.has_value(); }
  void stop() { estimate_.reset(); }
  /// After the track's last picture: begins, begins anew where the monocular map was corrected, and goes on
  /// where no scan comes.
  void follow(RecentPath& path, const JointStart& start, const PlaneState& plane);
  /// Begins anew with what it knows where the path was mended.
  void restart(const RecentPath& path);
  /// The pose counts from another level: how sure it is there, deviations of x, y, z (m) and heading (rad).
  void changeLevel(const RecentPath& path, const Eigen::Vector4d& sigmas);
  /// A scan that grid SLAM matched. False: it was not used, as most lie too near the last state. `at_once`:
  /// any that is newer will do.
  bool addLidar(RecentPath& path, common::Utime utime, const LidarFix& lidar, const PlaneState& plane,
                bool at_once);
  /// The scale (logarithm) that the LiDAR's ranges at map points show at a picture.
  void addScale(common::Utime utime, double log_scale);

  double scale() const;
  /// Of (position in world, rotation vector in world) of the camera.
  Eigen::Matrix<double, 6, 6> covariance() const;

 private:
  void begin(const Track& last, const JointStart& start);
  /// The same with what the window knows and pose by the path.
  void begin(const Track& last, const JointVector& sigmas);
  /// A state at `utime` by the path so far; then the path goes through the window's estimate.
  void add(RecentPath& path, common::Utime utime, const std::optional<LidarFix>& lidar,
           const PlaneState& plane);
  bool standsOnFloor(const common::Pose3& T_world_camera, double way, const PlaneState& plane);

  const common::Pose3 T_camera_body_;
  JointWindow window_;
  std::optional<JointEstimate> estimate_;  // Of the last state.
  common::Utime utime_ = 0;                // Of that state.
  std::int32_t map_id_ = 0;
  std::int64_t map_revision_ = 0;
  double floor_way_ = 0.0;  // m, since the body was last off its level's floor
  struct Scale {
    common::Utime utime = 0;
    double log_scale = 0.0;
  };
  std::optional<Scale> scale_;
};

}  // namespace rubble::fusion
