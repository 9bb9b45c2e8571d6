#include "recent_path.h"

#include <algorithm>
#include <iterator>

namespace rubble::fusion {

using common::Pose3;
using common::Utime;

namespace {

constexpr Utime kSpan = 2 * common::kMicrosecondsPerSecond;
constexpr Utime kVelocitySpan = common::kMicrosecondsPerSecond / 10;

}  // namespace

void RecentPath::add(const Track& track) {
  tracks_.push_back(track);
  while (track.utime - tracks_.front().utime > kSpan) {
    tracks_.pop_front();
  }
}

const Track* RecentPath::lastTracked() const {
  const auto found =
      std::find_if(tracks_.rbegin(), tracks_.rend(), [](const Track& t) { return t.tracking; });
  return found == tracks_.rend() ? nullptr : &*found;
}

const Track& RecentPath::shortlyBefore() const {
  return *std::find_if(tracks_.begin(), tracks_.end(),
                       [&](const Track& track) { return last().utime - track.utime <= kVelocitySpan; });
}

std::optional<Pose3> RecentPath::at(Utime utime) const {
  const auto after = std::lower_bound(tracks_.begin(), tracks_.end(), utime,
                                      [](const Track& track, Utime t) { return track.utime < t; });
  if (after == tracks_.end()) {
    return std::nullopt;
  }
  if (after->utime == utime) {
    return after->T_world_camera;
  }
  if (after == tracks_.begin()) {
    return std::nullopt;
  }
  const auto before = std::prev(after);
  return common::blend(
      before->T_world_camera, after->T_world_camera,
      static_cast<double>(utime - before->utime) / static_cast<double>(after->utime - before->utime));
}

void RecentPath::correctFrom(Utime utime, const Pose3& T) {
  for (Track& track : tracks_) {
    if (track.utime >= utime) {
      track.T_world_camera = T * track.T_world_camera;
    }
  }
}

}  // namespace rubble::fusion
