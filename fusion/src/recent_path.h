#pragma once

#include <deque>
#include <optional>

#include "common/history.h"
#include "fusion_memory.h"

namespace rubble::fusion {

/// The last two seconds of the camera's way, picture by picture. A correction moves all of it, so that what
/// is compared with it later is compared with what is known now.
class RecentPath {
 public:
  void add(const Track& track);
  void dropLast() { tracks_.pop_back(); }

  bool empty() const { return tracks_.empty(); }
  std::size_t size() const { return tracks_.size(); }
  const Track& last() const { return tracks_.back(); }
  /// The last one that vision gave; null: none.
  const Track* lastTracked() const;
  /// `age` pictures ago; 0: the last.
  const Track& ago(std::size_t age) const { return tracks_[tracks_.size() - 1 - age]; }
  /// The oldest of the last tenth of a second: what velocities are taken from.
  const Track& shortlyBefore() const;

  /// T_world_camera between two pictures; empty outside.
  std::optional<common::Pose3> at(common::Utime utime) const;
  /// Moves all of it by T (world, from the left).
  void correct(const common::Pose3& T) { correctFrom(0, T); }
  /// Moves what came at `utime` and later.
  void correctFrom(common::Utime utime, const common::Pose3& T);

 private:
  std::deque<Track> tracks_;
};

}  // namespace rubble::fusion
