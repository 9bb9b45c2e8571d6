#pragma once

#include <rubble/camera_info_t.hpp>

#include "common/geometry.h"
#include "common/robot_config.h"

namespace rubble::lcm_io {

/// `p[3]` (m) and `q[4]` (w, x, y, z) of a message as a transform. Throws Error for a quaternion
/// far from unit length or for values that are not finite.
common::Pose3 poseFromMessage(const double* p, const double* q);

void poseToMessage(const common::Pose3& T, double* p, double* q);

/// Throws Error for a calibration that is none.
common::RobotConfig::Intrinsics intrinsicsFromMessage(const rubble::camera_info_t& info);

/// All of the message but its utime.
void intrinsicsToMessage(const common::RobotConfig::Intrinsics& intrinsics, rubble::camera_info_t& info);

}  // namespace rubble::lcm_io
