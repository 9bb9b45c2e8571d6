#pragma once

#include <memory>
#include <variant>
#include <vector>

#include "geometry/two_view.h"
#include "map/matching.h"

namespace rubble::slam_mono {

/// Pose of a frame as it survives corrections of the map: relative to a keyframe.
struct RelativePose {
  KeyframeId reference = kNoKeyframe;
  common::Pose3 T_camera_reference = common::Pose3::Identity();
  double reference_scale = 1.0;  ///< Keyframe::scale when it was measured

  /// Of a camera pose in the map as it is.
  static RelativePose of(const Keyframe& keyframe, const common::Pose3& T_camera_mono);
  /// In the map as it is now; `keyframe` is the reference.
  common::Pose3 T_camera_mono(const Keyframe& keyframe) const;
};

/// What the tracker saw of the map's points since its last request.
struct PointStatistics {
  std::vector<PointId> visible;  ///< one entry per frame and point
  std::vector<PointId> found;
};

/// A tracked frame that shall become a keyframe.
struct NewKeyframe {
  std::shared_ptr<const Frame> frame;
  PointMatches points;
  RelativePose pose;
  PointStatistics statistics;
};

/// Two frames that start a map.
struct NewMap {
  std::shared_ptr<const Frame> first;
  std::shared_ptr<const Frame> second;
  struct Pair {
    std::uint32_t first = 0;   ///< feature
    std::uint32_t second = 0;  ///< feature
    Eigen::Vector3d p_first;   ///< the point in the first frame's camera
  };
  common::Pose3 T_second_first;
  std::vector<Pair> pairs;
  /// What lies in between, oldest first: to be located once the map stands.
  std::vector<std::shared_ptr<const Frame>> between;
};

/// What the tracker asks of the mapper.
using MapRequest = std::variant<std::monostate, NewKeyframe, NewMap>;

}  // namespace rubble::slam_mono
