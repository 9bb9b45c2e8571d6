#pragma once

#include <string>
#include <vector>

#include "common/time.h"
#include "level.h"

namespace rubble::fusion {

/// What the LiDAR may do (as lidar_control_t).
enum class ControlState { kH = 0, kM = 1, kR = 2 };

struct PlaneStateConfig {
  std::string mode = "joint";
  double height_band = 0.25;     ///< m
  double largest_tilt = 0.0524;  ///< rad
  double leave_after = 0.2;      ///< s
  double return_band = 0.8;      ///< share of both limits
  double return_after = 0.4;     ///< s
  int verify_scans = 5;
  int observe_scans = 40;
  int contradictions = 12;
  bool levels = true;
  double floor_after = 1.0;  ///< s
};

/// The LiDAR's plane: height (m) of its origin over where it is on the floor of level 0, tilt (rad); and the
/// tilt of the body under it.
struct Plane {
  double height = 0.0;
  double tilt = 0.0;
  double body_tilt = 0.0;
};

/// Decides between H (the LiDAR's plane is usable), M (it is not) and R (it is again, to be verified).
/// Mode `lsm`: eq. 10 of Chen et al. 2017, height alone, at once. The other modes: height, tilt of the
/// LiDAR's plane and agreement of the scans, with hysteresis in value and time; and a body that seems nearly
/// level is no reason to stay in M: R asks the scans, for it may be vision that is wrong.
///
/// Beyond the paper, the LiDAR's plane may be usable on several levels. From M the robot returns to the level
/// whose floor is nearest in height. Where there is none, and it has come there over a slope and stands level
/// for a while, a new level begins (H). A level that no scan agrees with is left for the next one at that
/// height, at last for a new one.
class PlaneState {
 public:
  explicit PlaneState(const PlaneStateConfig& config) : config_(config) {}

  /// The plane at `utime`.
  /// An attitude that is not known leads to R.
  void addPlane(common::Utime utime, const Plane& plane, bool attitude_known);
  enum class Scan { kUnmatched, kContradicts, kAgrees };
  /// A scan handled under the present revision: whether it was matched on a usable plane, and with vision. In
  /// H contradiction leads to M. In R agreement leads to H, and so does a LiDAR that contradicts for long:
  /// world is the LiDAR's.
  /// Returns true when it was the latter: vision was wrong.
  bool addScan(Scan scan);

  ControlState state() const { return state_; }
  /// Grows with every change of state or level.
  std::int64_t revision() const { return revision_; }
  /// The one that the robot is on; in M, was on last.
  int levelId() const { return level_; }
  const Level& level() const { return levels_[static_cast<std::size_t>(level_)]; }
  const std::vector<Level>& levels() const { return levels_; }
  /// How sure the present level's place in world is.
  void link(const Eigen::Vector2d& origin, const Eigen::Matrix4d& covariance);
  /// Scans up to here may be committed to the map.
  common::Utime confirmed() const { return confirmed_; }
  /// Contradiction led out of H, and the robot has stood level all the while: no slope can be the reason.
  bool contradictedOnLevelGround() const { return contradicted_on_level_; }
  /// How often contradiction led to M.
  int contradicted() const { return contradicted_; }
  /// Goes on from a checkpoint; `level` is one of `levels`.
  void restore(ControlState state, std::int64_t revision, const std::vector<Level>& levels, int level);
  /// Whether a plane like this may be trusted, with the margin of a return.
  bool usable(const Plane& plane) const { return within(plane, config_.return_band); }
  /// Not clearly off the level: by as much vision's attitude and height may be wrong.
  bool doubtful(const Plane& plane) const;

 private:
  bool within(const Plane& plane, double share) const;
  double offFloor(const Plane& plane, int level) const;
  /// In M: the level that the plane is held against.
  void lookAround(common::Utime utime, const Plane& plane);
  void watchFloor(common::Utime utime, const Plane& plane);
  /// The robot has stood level for a while where it came to over a slope.
  bool standsOnNewFloor() const;
  void beginLevel();
  /// In R, where no scan agrees.
  void tryNextLevel();
  void change(ControlState state);

  PlaneStateConfig config_;
  ControlState state_ = ControlState::kH;
  std::int64_t revision_ = 0;
  common::Utime confirmed_ = 0;
  common::Utime last_usable_ = 0;
  common::Utime last_unusable_ = 0;
  common::Utime last_beyond_doubt_ = 0;  // Not in M, or there and clearly off the level.
  int verified_ = 0;                     // Scans in a row that agree.
  int contradicting_ = 0;                // Scans in a row that do not.
  int unmatched_ = 0;                    // Scans in a row, in R.
  int contradicted_ = 0;
  bool stands_level_ = false;
  bool contradicted_on_level_ = false;
  bool attitude_known_ = true;

  std::vector<Level> levels_{1};
  int level_ = 0;
  int judged_ = 0;     // The level that planes are held against.
  int first_try_ = 0;  // The level that R began on.
  /// What the robot stands on, while it stands level at one height.
  struct Floor {
    common::Utime since = 0;
    common::Utime now = 0;
    double sum = 0.0;
    int count = 0;
    double height() const { return sum / count; }
  };
  Floor floor_;
  Plane plane_;
  common::Utime time_ = 0;
  common::Utime steep_ = 0;  // How long the body has been tilted since H.
};

}  // namespace rubble::fusion
