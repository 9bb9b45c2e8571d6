#pragma once

#include "common/geometry.h"

namespace rubble::lcm_io {

/// `p[3]` (m) and `q[4]` (w, x, y, z) of a message as a transform. Throws Error for a quaternion
/// far from unit length or for values that are not finite.
common::Pose3 poseFromMessage(const double* p, const double* q);

void poseToMessage(const common::Pose3& T, double* p, double* q);

}  // namespace rubble::lcm_io
