#pragma once

#include <filesystem>

namespace rubble::tools {

/// Writes the pictures of an LCM log in the layout of the TUM data sets: rgb.txt, rgb/SECONDS.jpg (bytes
/// untouched) or .png, calib.txt from the first CAMERA_INFO, groundtruth.txt from GROUND_TRUTH of the camera.
/// Throws Error.
void exportTum(const std::filesystem::path& log, const std::filesystem::path& dir);

}  // namespace rubble::tools
