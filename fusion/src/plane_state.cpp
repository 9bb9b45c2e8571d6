#include "plane_state.h"

#include <algorithm>
#include <cmath>

namespace rubble::fusion {

namespace {

/// A LiDAR that contradicts vision in R is believed after this many times the scans that show an attitude.
constexpr int kInsist = 3;
/// A body and a plane that vision sees tilted by no more than this (rad), and no more than this many times
/// the band off their height, may as well be level: so far its attitude can be off. Not ramps.
constexpr double kDoubtfulTilt = 0.12;
constexpr double kDoubtfulBand = 1.4;
constexpr double kDoubtAfter = 1.0;  // s in M
/// Tilt of a body that stands level (rad).
constexpr double kLevelBody = 0.035;

}  // namespace

void PlaneState::change(ControlState state) {
  state_ = state;
  ++revision_;
  verified_ = 0;
  contradicting_ = 0;
}

bool PlaneState::within(const Plane& plane, double share) const {
  return std::abs(plane.height) <= share * config_.height_band &&
         (config_.mode == "lsm" || plane.tilt <= share * config_.largest_tilt);
}

bool PlaneState::doubtful(const Plane& plane) const {
  return config_.mode != "lsm" && std::abs(plane.height) <= kDoubtfulBand * config_.height_band &&
         std::max(plane.tilt, plane.body_tilt) <= kDoubtfulTilt;
}

void PlaneState::addPlane(common::Utime utime, const Plane& plane, bool attitude_known) {
  const bool robust = config_.mode != "lsm";
  const auto longer = [&](common::Utime since, double seconds) {
    return utime - since > (robust ? common::utimeFromSeconds(seconds) : 0);
  };
  attitude_known_ = attitude_known || !robust;
  if (last_usable_ == 0) {
    last_usable_ = last_unusable_ = last_beyond_doubt_ = utime;
  }
  if (within(plane, 1.0)) {
    last_usable_ = utime;
  }
  if (!usable(plane)) {
    last_unusable_ = utime;
  }
  level_ = usable(plane) && plane.body_tilt <= kLevelBody;
  contradicted_on_level_ = contradicted_on_level_ && level_ && state_ != ControlState::kH;
  if (state_ != ControlState::kM || !doubtful(plane)) {
    last_beyond_doubt_ = utime;
  }
  if (!attitude_known_) {
    // The LiDAR is all there is: it goes on matching.
    if (state_ != ControlState::kR) {
      change(ControlState::kR);
    }
  } else if (state_ == ControlState::kM) {
    if (longer(last_unusable_, config_.return_after) || (robust && longer(last_beyond_doubt_, kDoubtAfter))) {
      change(ControlState::kR);
    }
  } else if (longer(last_usable_, config_.leave_after) && (state_ == ControlState::kH || !doubtful(plane))) {
    change(ControlState::kM);
  } else if (state_ == ControlState::kH && last_usable_ == utime) {
    confirmed_ = utime - common::utimeFromSeconds(config_.leave_after);
  }
}

bool PlaneState::addScan(Scan scan) {
  verified_ = scan == Scan::kAgrees ? verified_ + 1 : 0;
  contradicting_ = scan == Scan::kContradicts ? contradicting_ + 1 : 0;
  if (state_ == ControlState::kH && config_.mode != "lsm" && contradicting_ >= config_.contradictions) {
    ++contradicted_;
    contradicted_on_level_ = level_;
    change(ControlState::kM);
  } else if (state_ == ControlState::kR) {
    const bool insists = contradicting_ >= kInsist * config_.observe_scans;
    if (insists || verified_ >= (attitude_known_ ? config_.verify_scans : config_.observe_scans)) {
      change(ControlState::kH);
      return insists;
    }
  }
  return false;
}

void PlaneState::restore(ControlState state, std::int64_t revision) {
  state_ = state;
  revision_ = revision;
}

}  // namespace rubble::fusion
