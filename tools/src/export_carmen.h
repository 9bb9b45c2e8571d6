#pragma once

#include <filesystem>

namespace rubble::tools {

/// Writes the scans of an LCM log as a CARMEN log: ODOM lines, and a FLASER line per scan with the nearest
/// odometry; ROBOTLASER1 instead where the beams are not FLASER's 180 degrees ahead (then for the whole log).
/// Without odometry its fields are zero. Throws Error.
void exportCarmen(const std::filesystem::path& log, const std::filesystem::path& file);

}  // namespace rubble::tools
