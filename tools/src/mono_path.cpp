#include "mono_path.h"

#include <algorithm>
#include <utility>

#include "lcm_io/conversions.h"

namespace rubble::tools {

using lcm_io::poseFromMessage;

void MonoPath::add(const rubble::mono_map_t& message) {
  for (const rubble::mono_keyframe_t& k : message.keyframes) {
    keyframes_[k.id] = {k.map_id, -1, 1.0, poseFromMessage(k.p_mono_camera, k.q_mono_camera), k.scale};
  }
  for (const rubble::mono_removed_keyframe_t& k : message.removed) {
    keyframes_[k.id] = {k.map_id, k.parent, k.parent_scale,
                        poseFromMessage(k.p_parent_camera, k.q_parent_camera), k.scale};
  }
  for (const rubble::mono_frame_t& f : message.frames) {
    frames_.push_back(
        {f.utime,
         {0, f.keyframe_id, f.keyframe_scale, poseFromMessage(f.p_keyframe_camera, f.q_keyframe_camera)}});
  }
}

std::optional<MonoPath::Anchor> MonoPath::inMono(Anchor anchor) const {
  // A removed keyframe hangs on an older one: the chain ends. Messages are not to be trusted with that.
  for (std::size_t steps = 0; anchor.parent >= 0; ++steps) {
    const auto found = keyframes_.find(anchor.parent);
    if (found == keyframes_.end() || steps > keyframes_.size()) {
      return std::nullopt;
    }
    // In the scale of the parent's last known pose; how that has grown since is the next step's.
    const Anchor& parent = found->second;
    anchor.T_parent_camera.translation() *= parent.scale / anchor.parent_scale;
    anchor.T_parent_camera = parent.T_parent_camera * anchor.T_parent_camera;
    anchor.map_id = parent.map_id;
    anchor.parent = parent.parent;
    anchor.parent_scale = parent.parent_scale;
  }
  return anchor;
}

MonoPath::Result MonoPath::corrected() const {
  Result result;
  std::map<std::int32_t, common::Trajectory> maps;
  for (const Frame& frame : frames_) {
    if (const auto anchor = inMono(frame.anchor)) {
      maps[anchor->map_id].push_back({frame.utime, anchor->T_parent_camera});
    } else {
      ++result.without_keyframe;
    }
  }
  for (auto& [id, trajectory] : maps) {
    result.of_other_maps += trajectory.size();
    if (trajectory.size() > result.trajectory.size()) {
      result.trajectory = std::move(trajectory);
    }
  }
  result.of_other_maps -= result.trajectory.size();
  // A picture may have been located only after later ones.
  std::stable_sort(result.trajectory.begin(), result.trajectory.end(),
                   [](const auto& a, const auto& b) { return a.utime < b.utime; });
  return result;
}

}  // namespace rubble::tools
