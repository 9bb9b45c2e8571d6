#include "turn_check.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>

#include "common/geometry.h"

namespace rubble::fusion {

using common::Utime;

namespace {

/// Turns over this time are compared, at the time of a scan that vision has passed.
constexpr Utime kSpan = common::kMicrosecondsPerSecond;
constexpr Utime kKept = 2 * common::kMicrosecondsPerSecond;
/// Nobody knows how it turned in a longer pause.
constexpr Utime kGap = common::kMicrosecondsPerSecond / 5;
/// A scan that has jumped by more than this (rad) from the last one was matched somewhere else.
constexpr double kJump = 0.15;
/// So far apart (rad) for so many scans is astray; so near for so many is found again.
constexpr double kApart = 0.06;
constexpr int kApartScans = 8;
constexpr double kTogether = 0.03;
constexpr int kTogetherScans = 40;

/// Between two neighbours; empty outside and in a pause.
std::optional<double> at(const std::deque<std::pair<Utime, double>>& headings, Utime utime) {
  const auto after = std::lower_bound(headings.begin(), headings.end(), utime,
                                      [](const auto& entry, Utime t) { return entry.first < t; });
  if (after == headings.end() || (after == headings.begin() && after->first != utime)) {
    return std::nullopt;
  }
  if (after->first == utime) {
    return after->second;
  }
  const auto before = std::prev(after);
  if (after->first - before->first > kGap) {
    return std::nullopt;
  }
  return std::lerp(
      before->second, after->second,
      static_cast<double>(utime - before->first) / static_cast<double>(after->first - before->first));
}

}  // namespace

void TurnCheck::add(Headings& headings, Utime utime, double heading) {
  if (!headings.empty()) {
    if (utime <= headings.back().first) {
      return;
    }
    heading = headings.back().second + common::wrapAngle(heading - headings.back().second);
  }
  headings.emplace_back(utime, heading);
  while (utime - headings.front().first > kKept) {
    headings.pop_front();
  }
}

void TurnCheck::addVision(Utime utime, std::int32_t map_id, std::int64_t map_revision,
                          const Eigen::Matrix3d& R_mono_lidar, const Eigen::Matrix3d& R_world_lidar) {
  if (map_id != map_id_ || map_revision != map_revision_) {
    map_id_ = map_id;
    map_revision_ = map_revision;
    R_world_mono_ = R_world_lidar * R_mono_lidar.transpose();
    vision_.clear();
  }
  add(vision_, utime, common::rpyFromRotation(R_world_mono_ * R_mono_lidar).yaw);
}

void TurnCheck::addLidar(Utime utime, double heading) {
  if (!lidar_.empty() && std::abs(common::wrapAngle(heading - lidar_.back().second)) > kJump) {
    lidar_.clear();
  }
  add(lidar_, utime, heading);
  compare();
}

void TurnCheck::compare() {
  if (vision_.empty()) {
    return;
  }
  const auto until = std::find_if(lidar_.rbegin(), lidar_.rend(),
                                  [&](const auto& entry) { return entry.first <= vision_.back().first; });
  if (until == lidar_.rend()) {
    return;
  }
  const auto vision = at(vision_, until->first);
  const auto vision_before = at(vision_, until->first - kSpan);
  const auto lidar_before = at(lidar_, until->first - kSpan);
  if (!vision || !vision_before || !lidar_before) {
    return;
  }
  const double apart = std::abs((until->second - *lidar_before) - (*vision - *vision_before));
  apart_ = apart > kApart ? apart_ + 1 : 0;
  together_ = apart < kTogether ? together_ + 1 : 0;
  astray_ = astray_ ? together_ < kTogetherScans : apart_ >= kApartScans;
}

}  // namespace rubble::fusion
