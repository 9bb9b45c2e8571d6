#include "common/keyframe_poses.h"

namespace rubble::common {

std::optional<KeyframePoses::Located> KeyframePoses::locate(const AnchoredPose& pose) const {
  Pose3 T = pose.T_keyframe_camera;
  std::int32_t id = pose.keyframe_id;
  double scale = pose.keyframe_scale;
  double growth = 1.0;
  // A removed keyframe hangs on an older one: the chain ends. Messages are not to be trusted with that.
  for (std::size_t steps = 0; steps <= keyframes_.size(); ++steps) {
    const auto found = keyframes_.find(id);
    if (found == keyframes_.end()) {
      return std::nullopt;
    }
    const Keyframe& keyframe = found->second;
    T.translation() *= keyframe.scale / scale;
    growth *= keyframe.scale / scale;
    T = keyframe.T_parent_camera * T;
    if (keyframe.parent < 0) {
      return Located{keyframe.map_id, T, growth};
    }
    id = keyframe.parent;
    scale = keyframe.parent_scale;
  }
  return std::nullopt;
}

}  // namespace rubble::common
