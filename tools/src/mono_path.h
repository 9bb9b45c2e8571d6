#pragma once

#include <cstddef>
#include <rubble/mono_map_t.hpp>
#include <vector>

#include "common/keyframe_poses.h"
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
  common::KeyframePoses keyframes_;
  std::vector<common::AnchoredPose> pictures_;
};

}  // namespace rubble::tools
