#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <span>
#include <string>

#include "alignment_window.h"
#include "common/history.h"
#include "common/keyframe_poses.h"
#include "common/robot_config.h"
#include "corrected_motion.h"
#include "fusion_config.h"
#include "fusion_memory.h"
#include "joint/joint_path.h"
#include "levelling.h"
#include "recent_path.h"
#include "turn_check.h"

namespace rubble::fusion {

struct LidarMeasurement {
  common::Utime utime = 0;
  common::Pose2 T_world_lidar;  ///< level
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();
  bool good = false;           ///< matched, and to be trusted
  bool tilt_guessed = false;   ///< the scan's attitude had not arrived
  std::int64_t revision = -1;  ///< of the control state it was handled under; -1: none yet
};

struct MonoMeasurement {
  common::Utime utime = 0;
  bool tracking = false;
  std::int32_t map_id = 0;
  std::int64_t map_revision = 0;
  common::Pose3 T_mono_camera = common::Pose3::Identity();
};

/// The full state of eq. 1 and 2, and how far it is to be trusted.
struct RobotState {
  common::Utime utime = 0;
  common::Pose3 T_world_body = common::Pose3::Identity();
  Eigen::Vector3d v_world_body = Eigen::Vector3d::Zero();  ///< m/s
  Eigen::Vector3d w_body = Eigen::Vector3d::Zero();        ///< rad/s
  /// Of (x, y, z; rotation vector in world).
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Identity();
  bool attitude_known = true;
};

/// Joins the planar pose of grid SLAM with the 6D pose of monocular SLAM (Chen et al. 2017, section IV). In H
/// the LiDAR gives x, y and heading; vision carries the pose from one scan to the next and gives height and
/// tilt. In M vision carries it alone, at the scale and attitude that were learnt in H. In mode joint a
/// sliding window holds the pose once the scale is firm. Synchronous, deterministic, one owner.
class PoseFusion {
 public:
  PoseFusion(const FusionConfig& config, const common::RobotConfig& robot);

  /// Angles of the stabiliser as measured (rad).
  void addPlate(common::Utime utime, double roll, double pitch);
  void addLidar(const LidarMeasurement& lidar);
  /// The state at the picture's time. Throws common::Error for time that does not increase.
  RobotState addMono(const MonoMeasurement& mono);
  /// The state without a picture: vision is silent.
  RobotState advance(common::Utime utime);
  /// Pictures of the monocular map at `revision`, with the keyframes as they are then: the alignment is
  /// estimated again.
  void addPictures(std::span<const common::AnchoredPose> pictures, const common::KeyframePoses& keyframes,
                   std::int64_t revision);

  /// Mode joint: the scale (logarithm) that the LiDAR's ranges show at the last picture. A map whose scale
  /// nobody knows is anchored by some that agree.
  void addScale(common::Utime utime, double log_scale);

  const PlaneState& plane() const { return plane_; }
  /// Where the LiDAR sits on the camera, with the plate as it stood.
  common::Pose3 T_camera_lidar(common::Utime utime) const;
  /// Set-points for `utime` from the state then.
  PlateAngles levelling(common::Utime utime) const;

  std::int32_t mapId() const { return map_id_; }
  std::int64_t mapRevision() const { return map_revision_; }
  /// Of the present monocular map; empty before its first picture.
  std::optional<MapAlignment> alignment() const;
  /// Metres per unit of a monocular map, as far as it is known.
  std::optional<double> scaleOf(std::int32_t map_id) const;
  /// Or only pauses: a picture that comes late is no loss.
  bool visionTracks() const;
  /// It turns otherwise than the LiDAR does and is taken for lost.
  bool visionAstray() const { return turns_.astray(); }
  /// Time of the last scan that the pose has followed; 0: none yet.
  common::Utime lastLidar() const { return last_lidar_; }
  /// What contradicts the calibration, in words; empty when nothing does.
  std::string complaint() const { return window_.complaint(); }

  FusionMemory memory() const;
  /// Goes on from there. Call it first.
  void restore(const FusionMemory& memory);

 private:
  bool lidarMatches(common::Utime now) const;
  common::Pose3 carry(const MonoMeasurement& mono);
  /// Puts how the camera moved while the map was corrected where it was guessed.
  void mendMotion();
  /// x, y and heading of the body as in `T_world_camera`, height and tilt as in `T_seen`.
  common::Pose3 planarAs(const common::Pose3& T_world_camera, const common::Pose3& T_seen) const;
  /// Scans whose time vision has reached.
  void useWaiting();
  void useLidar(const LidarMeasurement& lidar);
  /// Vision that goes astray on the level is forgotten: its map is begun anew once it is found again.
  void checkTurns(const LidarMeasurement& lidar);
  /// The scale of the present map is learnt anew, from the attitude as it is now.
  void distrustVision();
  void noteVelocity(const LidarMeasurement& lidar);
  common::Pose3 extrapolate(common::Utime utime) const;
  Plane planeOf(const common::Pose3& T_world_camera, common::Utime utime) const;
  RobotState addTrack(const Track& track);
  /// After plane_ may have gone to another level.
  void followLevel();
  /// Without vision the attitude stays known on level ground only.
  void watchAttitude();
  /// Turns the way so that the body stands level now.
  void standLevel();
  /// The same, and lifts it so that the plane seen lies where it is on the level's floor.
  void standOnFloor(const Plane& plane);
  RobotState state() const;
  /// Of the body: (x, y, z; rotation vector in world).
  Eigen::Matrix<double, 6, 6> covariance() const;
  /// Vision tells how far the robot moves. In H the LiDAR does while the scale is young: a map that was begun
  /// in a turn may have a scale that nobody measured. In R, too, while it is learnt anew.
  bool visionCarries() const;
  /// The map lies so that the last picture is where the pose is.
  void anchor(MapAlignment& map, double scale);
  void addSamples(std::span<const common::AnchoredPose> pictures);
  void solve(const common::KeyframePoses& keyframes);
  /// In H: a share of height and tilt.
  void pullToAlignment(const common::Pose3& T_world_camera);
  /// In M: a correction of the map has taken out the drift since.
  void goToAlignment(const common::Pose3& T_world_camera);

  bool jointHolds() const { return joint_ && joint_->active(); }

  const FusionConfig config_;
  const common::RobotConfig robot_;
  const common::Pose3 T_camera_body_;
  PlaneState plane_;

  common::History<Eigen::Vector2d> plate_{4 * common::kMicrosecondsPerSecond};
  std::deque<LidarMeasurement> waiting_;  // Newer than the last picture.
  common::History<common::Pose2> lidar_;  // In H, without a gap.
  int level_ = 0;                         // That the pose counts from.
  common::Utime last_lidar_ = 0;
  common::Pose2 T_world_lidar_last_;
  Eigen::Vector3d lidar_velocity_ = Eigen::Vector3d::Zero();  // x, y m/s, heading rad/s in world
  Eigen::Matrix3d lidar_covariance_ = Eigen::Matrix3d::Identity();
  RecentPath path_;
  std::optional<JointPath> joint_;  // In mode joint.
  AlignmentWindow window_;
  CorrectedMotion corrected_;
  TurnCheck turns_;
  std::map<std::int32_t, MapAlignment> maps_;
  std::deque<double> anchors_;  // Logarithms of a scale that is not known yet.
  std::int32_t map_id_ = 0;
  std::int64_t map_revision_ = 0;
  std::int64_t solved_revision_ = 0;
  bool attitude_known_ = true;
  bool anchored_ = true;              // The pose goes back to a LiDAR pose.
  bool came_back_ = false;            // Out of R, and the pose has not followed a scan since.
  double drift_ = 0.0;                // m, since the LiDAR last gave the pose
  double time_without_vision_ = 0.0;  // s
};

}  // namespace rubble::fusion
