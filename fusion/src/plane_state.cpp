#include "plane_state.h"

#include <cmath>

namespace rubble::fusion {

void PlaneState::change(ControlState state) {
  state_ = state;
  ++revision_;
  verified_ = 0;
}

void PlaneState::addPlane(common::Utime utime, double height, double tilt, bool attitude_known) {
  const auto seconds = [](double s) { return common::utimeFromSeconds(s); };
  const bool robust = config_.mode != "lsm";
  const auto within = [&](double share) {
    return std::abs(height) <= share * config_.height_band &&
           (!robust || (attitude_known && tilt <= share * config_.largest_tilt));
  };
  if (last_usable_ == 0) {
    last_usable_ = last_unusable_ = utime;
  }
  if (within(1.0)) {
    last_usable_ = utime;
  }
  if (!within(config_.return_band)) {
    last_unusable_ = utime;
  }
  switch (state_) {
    case ControlState::kH:
    case ControlState::kR:
      if (utime - last_usable_ > seconds(robust ? config_.leave_after : 0.0)) {
        change(ControlState::kM);
      } else if (state_ == ControlState::kH && last_usable_ == utime) {
        confirmed_ = utime;
      }
      break;
    case ControlState::kM:
      if (utime - last_unusable_ >= seconds(robust ? config_.return_after : 0.0)) {
        change(ControlState::kR);
      }
      break;
  }
}

void PlaneState::addScan(bool agrees) {
  if (state_ == ControlState::kR) {
    verified_ = agrees ? verified_ + 1 : 0;
    if (verified_ >= config_.verify_scans) {
      change(ControlState::kH);
    }
  }
}

void PlaneState::restore(ControlState state, std::int64_t revision) {
  state_ = state;
  revision_ = revision;
}

}  // namespace rubble::fusion
