#pragma once

#include <filesystem>
#include <vector>

#include "common/geometry.h"
#include "common/time.h"

namespace rubble::common {

struct StampedPose {
  Utime utime = 0;
  Pose3 T_a_b = Pose3::Identity();
};

/// Poses in increasing time.
using Trajectory = std::vector<StampedPose>;

/// The pose nearest in time; null where none is within `max_difference` microseconds.
const StampedPose* nearestPose(const Trajectory& trajectory, Utime utime, Utime max_difference);

/// Reads a TUM file: lines `seconds x y z qx qy qz qw`, `#` starts a comment. Lines out of order are
/// sorted. Throws Error naming file and line.
Trajectory readTum(const std::filesystem::path& path);

/// Writes a TUM file with microsecond stamps and nanometre/nanoradian digits. Throws Error.
void writeTum(const std::filesystem::path& path, const Trajectory& trajectory);

}  // namespace rubble::common
