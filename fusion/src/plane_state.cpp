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
/// A new floor is level within this (m), and came after the body was tilted by more than doubt for so long.
constexpr double kFloorBand = 0.05;
constexpr common::Utime kClimb = common::kMicrosecondsPerSecond / 2;
/// As many as slam_lidar keeps.
constexpr std::size_t kMostLevels = 64;

}  // namespace

void PlaneState::change(ControlState state) {
  state_ = state;
  ++revision_;
  verified_ = 0;
  contradicting_ = 0;
  unmatched_ = 0;
  steep_ = state == ControlState::kH ? 0 : steep_;
}

void PlaneState::link(const Eigen::Vector2d& origin, const Eigen::Matrix4d& covariance) {
  levels_[static_cast<std::size_t>(level_)].origin = origin;
  levels_[static_cast<std::size_t>(level_)].covariance = covariance;
}

double PlaneState::offFloor(const Plane& plane, int level) const {
  return std::abs(plane.height - levels_[static_cast<std::size_t>(level)].floor);
}

bool PlaneState::within(const Plane& plane, double share) const {
  return offFloor(plane, judged_) <= share * config_.height_band &&
         (config_.mode == "lsm" || plane.tilt <= share * config_.largest_tilt);
}

bool PlaneState::doubtful(const Plane& plane) const {
  return config_.mode != "lsm" && offFloor(plane, judged_) <= kDoubtfulBand * config_.height_band &&
         std::max(plane.tilt, plane.body_tilt) <= kDoubtfulTilt;
}

void PlaneState::addPlane(common::Utime utime, const Plane& plane, bool attitude_known) {
  const bool robust = config_.mode != "lsm";
  const auto longer = [&](common::Utime since, double seconds) {
    return utime - since > (robust ? common::utimeFromSeconds(seconds) : 0);
  };
  attitude_known_ = attitude_known || !robust;
  if (last_usable_ == 0) {
    last_usable_ = last_unusable_ = last_beyond_doubt_ = time_ = utime;
  }
  lookAround(utime, plane);
  watchFloor(utime, plane);
  if (within(plane, 1.0)) {
    last_usable_ = utime;
  }
  if (!usable(plane)) {
    last_unusable_ = utime;
  }
  stands_level_ = usable(plane) && plane.body_tilt <= kLevelBody;
  contradicted_on_level_ = contradicted_on_level_ && stands_level_ && state_ != ControlState::kH;
  if (state_ != ControlState::kM || !doubtful(plane)) {
    last_beyond_doubt_ = utime;
  }
  if (!attitude_known_) {
    // The LiDAR is all there is: it goes on matching.
    if (state_ != ControlState::kR) {
      first_try_ = level_;
      change(ControlState::kR);
    }
  } else if (state_ == ControlState::kM) {
    if (longer(last_unusable_, config_.return_after) || (robust && longer(last_beyond_doubt_, kDoubtAfter))) {
      level_ = first_try_ = judged_;
      change(ControlState::kR);
    } else if (!doubtful(plane) && standsOnNewFloor()) {
      beginLevel();
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
  unmatched_ = scan == Scan::kUnmatched ? unmatched_ + 1 : 0;
  if (state_ == ControlState::kH && config_.mode != "lsm" && contradicting_ >= config_.contradictions) {
    ++contradicted_;
    contradicted_on_level_ = stands_level_;
    change(ControlState::kM);
  } else if (state_ == ControlState::kR) {
    const bool insists = contradicting_ >= kInsist * config_.observe_scans;
    if (insists || verified_ >= (attitude_known_ ? config_.verify_scans : config_.observe_scans)) {
      change(ControlState::kH);
      return insists;
    }
    if (unmatched_ >= kInsist * config_.observe_scans) {
      tryNextLevel();
    }
  }
  return false;
}

void PlaneState::lookAround(common::Utime utime, const Plane& plane) {
  int nearest = level_;
  if (state_ == ControlState::kM) {
    for (int level = 0; level < static_cast<int>(levels_.size()); ++level) {
      nearest = offFloor(plane, level) < offFloor(plane, nearest) ? level : nearest;
    }
  }
  if (nearest != judged_) {
    judged_ = nearest;
    last_unusable_ = last_beyond_doubt_ = utime;
  }
}

void PlaneState::watchFloor(common::Utime utime, const Plane& plane) {
  if (state_ == ControlState::kM && plane.body_tilt > kDoubtfulTilt) {
    steep_ += utime - time_;
  }
  const bool stands = attitude_known_ && plane.body_tilt <= kLevelBody && plane.tilt <= config_.largest_tilt;
  if (!stands || (floor_.count > 0 && std::abs(plane.height - floor_.height()) > kFloorBand)) {
    floor_ = {utime, utime, 0.0, 0};
  }
  floor_.now = utime;
  floor_.sum += plane.height;
  ++floor_.count;
  plane_ = plane;
  time_ = utime;
}

bool PlaneState::standsOnNewFloor() const {
  return config_.levels && config_.mode != "lsm" && attitude_known_ && steep_ >= kClimb &&
         levels_.size() < kMostLevels &&
         floor_.now - floor_.since >= common::utimeFromSeconds(config_.floor_after);
}

void PlaneState::beginLevel() {
  levels_.push_back({.floor = floor_.height()});
  level_ = judged_ = static_cast<int>(levels_.size()) - 1;
  last_usable_ = time_;
  change(ControlState::kH);
}

void PlaneState::tryNextLevel() {
  const auto count = static_cast<int>(levels_.size());
  int next = level_;
  do {
    next = (next + 1) % count;
  } while (next != first_try_ && offFloor(plane_, next) > config_.height_band);
  if (next == first_try_ && standsOnNewFloor()) {
    beginLevel();
  } else if (next != level_) {
    level_ = judged_ = next;
    change(ControlState::kR);
  } else {
    unmatched_ = 0;
  }
}

void PlaneState::restore(ControlState state, std::int64_t revision, const std::vector<Level>& levels,
                         int level) {
  state_ = state;
  revision_ = revision;
  levels_ = levels;
  level_ = judged_ = first_try_ = level;
}

}  // namespace rubble::fusion
