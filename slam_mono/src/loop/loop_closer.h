#pragma once

#include <memory>
#include <optional>

#include "map/matching.h"
#include "map/places.h"
#include "slam_mono/mono_slam_config.h"

namespace rubble::slam_mono {

/// A keyframe that shows a place which the map, or another map, knows already.
struct LoopClosure {
  KeyframeId keyframe = kNoKeyframe;
  KeyframeId place = kNoKeyframe;
  /// From the keyframe's mono coordinates to the place's: what the correction has to do to it.
  Sim3 S_place_keyframe;
};

/// Looks for loop closures and merges (Mur-Artal et al. 2015, section VII): place recognition, similarity by
/// RANSAC, guided matching, confirmed by several keyframes. Reads snapshots, changes nothing.
class LoopCloser {
 public:
  LoopCloser(const Camera& camera, const OctaveScales& scales, const MonoSlamConfig::Loop& config);

  std::optional<LoopClosure> detect(const std::shared_ptr<const Map>& map, KeyframeId keyframe);

 private:
  std::optional<LoopClosure> verify(const Map& map, KeyframeId keyframe, KeyframeId place);
  /// Whether drift on the way between both may have come to what the closure would correct.
  bool plausibleDrift(const Map& map, const Keyframe& keyframe, const Keyframe& place,
                      const Sim3& S_place_keyframe) const;
  /// Counts in a row; true once enough keyframes have said the same.
  bool confirm(const Map& map, const LoopClosure& found);

  const Camera& camera_;
  const OctaveScales& scales_;
  const MonoSlamConfig::Loop config_;
  ProjectionMatcher matcher_;
  PlaceTable table_;
  std::optional<LoopClosure> pending_;
  int confirmations_ = 0;
  KeyframeId last_closed_ = kNoKeyframe;
};

}  // namespace rubble::slam_mono
