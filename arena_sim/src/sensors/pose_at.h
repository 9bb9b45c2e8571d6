#pragma once

#include <functional>

#include "common/geometry.h"

namespace rubble::arena_sim {

/// T_world_frame over time (s), exact.
using PoseAt = std::function<common::Pose3(double seconds)>;

}  // namespace rubble::arena_sim
