#include "plane_state.h"

#include <cmath>

namespace rubble::fusion {

namespace {

/// A LiDAR that contradicts vision in R is believed after this many times the scans that show an attitude.
constexpr int kInsist = 3;

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

void PlaneState::addPlane(common::Utime utime, const Plane& plane, bool attitude_known) {
  const bool robust = config_.mode != "lsm";
  const auto longer = [&](common::Utime since, double seconds) {
    return utime - since > (robust ? common::utimeFromSeconds(seconds) : 0);
  };
  attitude_known_ = attitude_known || !robust;
  if (last_usable_ == 0) {
    last_usable_ = last_unusable_ = utime;
  }
  if (within(plane, 1.0)) {
    last_usable_ = utime;
  }
  if (!usable(plane)) {
    last_unusable_ = utime;
  }
  if (!attitude_known_) {
    // The LiDAR is all there is: it goes on matching.
    if (state_ != ControlState::kR) {
      change(ControlState::kR);
    }
  } else if (state_ == ControlState::kM) {
    if (longer(last_unusable_, config_.return_after)) {
      change(ControlState::kR);
    }
  } else if (longer(last_usable_, config_.leave_after)) {
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
