#include "mono_path.h"

#include <algorithm>
#include <map>
#include <utility>

#include "lcm_io/mono_map.h"

namespace rubble::tools {

void MonoPath::add(const rubble::mono_map_t& message) {
  const auto pictures = lcm_io::readMonoMap(message, keyframes_);
  pictures_.insert(pictures_.end(), pictures.begin(), pictures.end());
}

MonoPath::Result MonoPath::corrected() const {
  Result result;
  std::map<std::int32_t, common::Trajectory> maps;
  for (const common::AnchoredPose& picture : pictures_) {
    if (const auto located = keyframes_.locate(picture)) {
      maps[located->map_id].push_back({picture.utime, located->T_mono_camera});
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
