#pragma once

#include <cstdint>
#include <map>
#include <optional>

#include "common/geometry.h"
#include "common/time.h"

namespace rubble::common {

/// A picture's pose relative to a keyframe of a monocular map, which later corrections move along.
struct AnchoredPose {
  Utime utime = 0;
  std::int32_t keyframe_id = -1;
  double keyframe_scale = 1.0;  ///< the keyframe's then
  Pose3 T_keyframe_camera = Pose3::Identity();
};

/// Where the keyframes of the monocular maps are, as far as is known. Finds where an anchored picture is
/// after all corrections since.
class KeyframePoses {
 public:
  struct Keyframe {
    std::int32_t map_id = 0;
    /// -1: the pose is T_mono_camera. Else the keyframe was removed and hangs on that one: T_parent_camera.
    std::int32_t parent = -1;
    double parent_scale = 1.0;  ///< the parent's then
    Pose3 T_parent_camera = Pose3::Identity();
    double scale = 1.0;  ///< by how much corrections have grown its surroundings since it was made
  };
  void set(std::int32_t id, const Keyframe& keyframe) { keyframes_[id] = keyframe; }

  struct Located {
    std::int32_t map_id = 0;
    Pose3 T_mono_camera;
    double growth = 1.0;  ///< of the picture's surroundings by corrections since
  };
  /// Empty where a keyframe was never heard of.
  std::optional<Located> locate(const AnchoredPose& pose) const;

 private:
  std::map<std::int32_t, Keyframe> keyframes_;
};

}  // namespace rubble::common
