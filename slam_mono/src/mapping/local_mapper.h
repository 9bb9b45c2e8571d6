#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "mapping/bundle.h"
#include "slam_mono/mono_slam_config.h"
#include "tracking/requests.h"

namespace rubble::slam_mono {

/// Owns the map and makes it grow: keyframes in, map points by triangulation, fusing, culling, local bundle
/// adjustment (Mur-Artal et al. 2015, section VI).
class LocalMapper {
 public:
  LocalMapper(const Camera& camera, const OctaveScales& scales, const MonoSlamConfig& config);

  /// Starts another map. Empty when the two views do not hold against bundle adjustment. Tiny maps that were
  /// left behind are dropped.
  std::optional<KeyframeId> start(const NewMap& request);
  /// Empty when the map has lost the keyframe's reference meanwhile. Bundle adjustment may be left to the
  /// next keyframe when that one is waiting already.
  std::optional<KeyframeId> insert(const NewKeyframe& request, bool with_adjustment = true);

  Map& map() { return map_; }
  const Map& map() const { return map_; }
  /// Puts a restored map in place of the present one.
  void replaceMap(Map map);

  /// Adds `points` to the keyframe where they are seen, replacing duplicates.
  void fuse(KeyframeId keyframe, const LocalPoints& points, double radius_factor);

 private:
  void countStatistics(const PointStatistics& statistics);
  void cullPoints(KeyframeId newest);
  void triangulate(KeyframeId newest);
  void triangulateWith(KeyframeId newest, KeyframeId other, double farthest);
  void fuseNeighbours(KeyframeId newest);
  void adjust(KeyframeId newest);
  /// Erases neighbours of `newest` that others can stand for: by their points, or, when they are no longer
  /// local, by their view.
  void cullKeyframes(KeyframeId newest);

  const Camera& camera_;
  const OctaveScales& scales_;
  const MonoSlamConfig config_;
  Map map_;
  ProjectionMatcher matcher_;
  std::vector<PointId> recent_;  // Points still to prove themselves.
};

}  // namespace rubble::slam_mono
