#pragma once

#include <filesystem>

namespace rubble::tools {

/// Writes what the processes published live (LIDAR_POSE, GRID_MAP, MONO_POSE, MONO_MAP in a log of the
/// console) as the result files of `rubble replay`. Throws common::Error for a log that cannot be read or
/// holds no result.
void exportResults(const std::filesystem::path& log, const std::filesystem::path& out_dir);

}  // namespace rubble::tools
