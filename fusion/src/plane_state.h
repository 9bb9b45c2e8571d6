#pragma once

#include <string>

#include "common/time.h"

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
};

/// The LiDAR's plane: height (m) of its origin over where it is on the level's floor, tilt (rad); and the
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
  std::int64_t revision() const { return revision_; }
  /// Scans up to here may be committed to the map.
  common::Utime confirmed() const { return confirmed_; }
  /// Contradiction led out of H, and the robot has stood level all the while: no slope can be the reason.
  bool contradictedOnLevelGround() const { return contradicted_on_level_; }
  /// How often contradiction led to M.
  int contradicted() const { return contradicted_; }
  /// Goes on from a checkpoint.
  void restore(ControlState state, std::int64_t revision);
  /// Whether a plane like this may be trusted, with the margin of a return.
  bool usable(const Plane& plane) const { return within(plane, config_.return_band); }

 private:
  bool within(const Plane& plane, double share) const;
  bool doubtful(const Plane& plane) const;
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
  int contradicted_ = 0;
  bool level_ = false;
  bool contradicted_on_level_ = false;
  bool attitude_known_ = true;
};

}  // namespace rubble::fusion
