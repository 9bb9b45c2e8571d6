#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "common/geometry.h"
#include "geometry/sim3.h"
#include "map/frame.h"

namespace rubble::slam_mono {

using KeyframeId = std::int32_t;
using PointId = std::uint32_t;
inline constexpr KeyframeId kNoKeyframe = -1;
inline constexpr PointId kNoPoint = std::numeric_limits<PointId>::max();

/// A map point seen as one feature of a keyframe.
struct Observation {
  KeyframeId keyframe = kNoKeyframe;
  std::uint32_t feature = 0;
};

/// A landmark. Lengths in the map's own scale, frame `mono` of its map.
struct MapPoint {
  int map_id = 0;
  Eigen::Vector3d p_mono_point = Eigen::Vector3d::Zero();
  /// One standard deviation of p_mono_point along its least certain direction (nearly the line of sight), at
  /// a pixel of noise and with the keyframes' poses taken as exact; at most ten times its distance.
  Eigen::Vector3d uncertainty = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< mean direction from the cameras to it, unit length
  double min_distance = 0.0;  ///< at which the descriptor's pyramid levels still see it
  double max_distance = 0.0;
  orb::Descriptor descriptor{};
  KeyframeId reference = kNoKeyframe;  ///< the keyframe that made it, or the next that saw it
  KeyframeId first = kNoKeyframe;      ///< newest keyframe when it was made
  int visible = 1;                     ///< frames that should have seen it
  int found = 1;                       ///< frames that did
  std::vector<Observation> observations;
};

/// A frame kept in the map.
struct Keyframe {
  KeyframeId id = kNoKeyframe;
  int map_id = 0;
  std::shared_ptr<const Frame> frame;
  common::Pose3 T_camera_mono = common::Pose3::Identity();
  /// By how much similarity corrections have grown its surroundings since it was made: what was measured
  /// relative to it earlier is to be multiplied by the ratio.
  double scale = 1.0;
  std::vector<PointId> points;                        ///< per feature; kNoPoint where none
  std::vector<std::pair<KeyframeId, int>> covisible;  ///< with points in common, most first
  KeyframeId parent = kNoKeyframe;                    ///< spanning tree
  std::vector<KeyframeId> loops;                      ///< keyframes that loop closures tied it to

  Eigen::Vector3d p_mono_camera() const { return T_camera_mono.inverse().translation(); }
};

/// All keyframes and map points, of one or several monocular maps (each with its own frame and scale, told
/// apart by map_id). A value with cheap copies: snapshot() shares everything with the original, which copies
/// a keyframe or block of points when it edits them. Snapshots may be read by any thread.
class Map {
 public:
  /// For other threads. Keeps what it holds alive; later edits of this map don't show in it.
  std::shared_ptr<const Map> snapshot();

  /// Grows with every snapshot: two snapshots of one epoch are the same.
  std::uint64_t epoch() const { return epoch_; }

  /// Null when there is none (any more).
  const Keyframe* keyframe(KeyframeId id) const;
  const MapPoint* point(PointId id) const;
  /// To be changed; the keyframe or point must exist.
  Keyframe& edit(KeyframeId id);
  MapPoint& editPoint(PointId id);

  /// Ids of all that exist, ascending.
  std::vector<KeyframeId> keyframes() const;
  std::vector<PointId> points() const;
  /// What the keyframes see, ascending.
  std::vector<PointId> pointsOf(std::span<const KeyframeId> keyframes) const;
  std::size_t keyframeCount() const { return keyframe_count_; }
  std::size_t pointCount() const { return point_count_; }
  KeyframeId nextKeyframeId() const { return static_cast<KeyframeId>(keyframes_.size()); }
  PointId nextPointId() const { return next_point_; }
  /// Gives no keyframe an id below this.
  void skipKeyframeIds(KeyframeId next);
  std::size_t keyframeCount(int map_id) const;
  std::vector<int> mapIds() const;  ///< ascending

  /// Sets the id. Its points must be empty (kNoPoint); observations are added one by one.
  KeyframeId addKeyframe(Keyframe keyframe);
  PointId addPoint(MapPoint point);
  void addObservation(PointId point, KeyframeId keyframe, std::uint32_t feature);
  /// Erases the point, too, when fewer than two observations are left.
  void eraseObservation(PointId point, KeyframeId keyframe);
  void erasePoint(PointId id);
  /// Hands the observations of `id` over to `by`, where the keyframe does not yet see `by`.
  void replacePoint(PointId id, PointId by);
  /// Children in the spanning tree find a new parent.
  void eraseKeyframe(KeyframeId id);

  /// Index of `keyframe` among the point's observations; empty when it does not see it.
  std::optional<std::uint32_t> featureOf(PointId point, KeyframeId keyframe) const;

  /// Uncertainty, descriptor, mean direction and distance limits from the observations.
  void refreshPoint(PointId id, const OctaveScales& scales);
  /// Who shares points with the keyframe, on both sides; gives it a parent when it has none.
  void refreshCovisibility(KeyframeId id);
  /// The n keyframes with most points in common, and n_second of each of theirs; never `id` itself.
  std::vector<KeyframeId> neighbours(KeyframeId id, std::size_t n, std::size_t n_second = 0) const;
  /// The keyframe itself and the n with most points in common, itself last.
  std::vector<KeyframeId> around(KeyframeId id, std::size_t n) const;
  /// Median distance of its points from the keyframe; 0 without points.
  double medianDistance(KeyframeId id) const;

  /// Moves a whole map into another one: p_new = S_new_old * p_old.
  void transform(int map_id, const Sim3& S_new_old, int new_map_id);
  void eraseMap(int map_id);

  /// Grows with every correction of the past that is more than local: loop closures, merges.
  std::int64_t revision = 0;

 private:
  friend class MapParser;
  static constexpr std::size_t kBlock = 32;
  using PointBlock = std::array<std::optional<MapPoint>, kBlock>;
  /// Copy on write: shared with snapshots taken after `epoch`.
  template <typename T>
  struct Shared {
    std::shared_ptr<T> value;
    std::uint64_t epoch = 0;
  };
  template <typename T>
  T& editable(Shared<T>& shared);
  void eraseSlot(PointId id);

  std::vector<Shared<Keyframe>> keyframes_;
  std::vector<Shared<PointBlock>> blocks_;
  PointId next_point_ = 0;
  std::size_t keyframe_count_ = 0;
  std::size_t point_count_ = 0;
  std::uint64_t epoch_ = 1;
};

}  // namespace rubble::slam_mono
