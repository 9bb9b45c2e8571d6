#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <rubble/mono_map_t.hpp>
#include <vector>

#include "common/trajectory.h"

namespace rubble::tools {

/// The path of the camera after all corrections: every tracked picture hangs on a keyframe, and MONO_MAP
/// tells where the keyframes are in the end.
class MonoPath {
 public:
  /// Throws common::Error for a pose that is none.
  void add(const rubble::mono_map_t& message);

  struct Result {
    /// T_mono_camera of the map with most pictures; poses of different maps cannot be compared.
    common::Trajectory trajectory;
    std::size_t of_other_maps = 0;     ///< pictures left out
    std::size_t without_keyframe = 0;  ///< pictures whose keyframe was never heard of (lost on the bus)
  };
  Result corrected() const;

 private:
  /// A keyframe or picture: relative to another keyframe, or in mono (parent -1).
  struct Anchor {
    std::int32_t map_id = 0;
    std::int32_t parent = -1;
    double parent_scale = 1.0;
    common::Pose3 T_parent_camera = common::Pose3::Identity();
    double scale = 1.0;  // Of a keyframe, when T_parent_camera was as it is here.
  };
  struct Frame {
    common::Utime utime = 0;
    Anchor anchor;
  };

  std::optional<Anchor> inMono(Anchor anchor) const;

  std::map<std::int32_t, Anchor> keyframes_;
  std::vector<Frame> frames_;
};

}  // namespace rubble::tools
