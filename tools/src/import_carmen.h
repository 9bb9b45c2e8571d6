#pragma once

#include <filesystem>

namespace rubble::tools {

/// Turns a CARMEN log (plain or .bz2) into an LCM log: SCAN, ODOMETRY, GROUND_TRUTH of the body. Throws
/// Error.
void importCarmen(const std::filesystem::path& input, const std::filesystem::path& output,
                  bool with_odometry);

}  // namespace rubble::tools
