#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <memory>
#include <rubble/mono_map_t.hpp>
#include <set>
#include <vector>

#include "common/time.h"
#include "map/map.h"
#include "slam_mono/frame_result.h"

namespace rubble::slam_mono {

/// Cuts the maps into MONO_MAP messages: tracked pictures and removed keyframes (once), what changed, and
/// older keyframes and points in turn.
class MonoMapPublisher {
 public:
  /// After every picture: a keyframe that comes and goes between two calls would be missed.
  void add(const FrameResult& result, const std::shared_ptr<const Map>& map);

  /// The next message, at most about 60 kB.
  rubble::mono_map_t next(common::Utime utime);

  /// Pictures, or changes of keyframes, have not been sent; points may take their time.
  bool behind() const { return !frames_.empty() || !removed_.empty() || !changed_.empty(); }

 private:
  class Message;
  /// As it was sent.
  struct SentPoint {
    bool exists = false;
    std::int32_t map_id = 0;
    std::array<float, 3> p_mono_point{};

    bool operator==(const SentPoint&) const = default;
  };

  void noteChanges(const Map& before, const Map& now);
  void addKeyframes(Message& message);
  void addPoints(Message& message);
  SentPoint pointNow(std::size_t id) const;

  std::shared_ptr<const Map> map_ = std::make_shared<const Map>();
  std::deque<rubble::mono_frame_t> frames_;
  std::deque<rubble::mono_removed_keyframe_t> removed_;
  std::set<KeyframeId> changed_;
  std::vector<SentPoint> points_;  // By id.
  KeyframeId next_repeated_keyframe_ = 0;
  std::size_t next_changed_point_ = 0;
  std::size_t next_repeated_point_ = 0;
};

}  // namespace rubble::slam_mono
