#pragma once

#include <rubble/mono_map_t.hpp>
#include <vector>

#include "common/keyframe_poses.h"

namespace rubble::lcm_io {

/// Takes a message's keyframes over into `keyframes` and returns its pictures. Throws common::Error for a
/// pose that is none.
std::vector<common::AnchoredPose> readMonoMap(const rubble::mono_map_t& message,
                                              common::KeyframePoses& keyframes);

}  // namespace rubble::lcm_io
