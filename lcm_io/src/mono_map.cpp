#include "lcm_io/mono_map.h"

#include "lcm_io/conversions.h"

namespace rubble::lcm_io {

std::vector<common::AnchoredPose> readMonoMap(const rubble::mono_map_t& message,
                                              common::KeyframePoses& keyframes) {
  for (const rubble::mono_keyframe_t& k : message.keyframes) {
    keyframes.set(k.id, {k.map_id, -1, 1.0, poseFromMessage(k.p_mono_camera, k.q_mono_camera), k.scale});
  }
  for (const rubble::mono_removed_keyframe_t& k : message.removed) {
    keyframes.set(k.id, {k.map_id, k.parent, k.parent_scale,
                         poseFromMessage(k.p_parent_camera, k.q_parent_camera), k.scale});
  }
  std::vector<common::AnchoredPose> pictures;
  pictures.reserve(message.frames.size());
  for (const rubble::mono_frame_t& f : message.frames) {
    pictures.push_back({f.utime, f.keyframe_id, f.keyframe_scale,
                        poseFromMessage(f.p_keyframe_camera, f.q_keyframe_camera)});
  }
  return pictures;
}

}  // namespace rubble::lcm_io
