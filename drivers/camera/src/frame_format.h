#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "camera_config.h"

namespace rubble::camera {

/// What a device says its pictures are.
struct FrameFormat {
  /// V4L2 FourCC.
  std::int32_t fourcc = 0;
  int width = 0;        ///< pixels
  int height = 0;       ///< pixels
  std::size_t row = 0;  ///< bytes from one row to the next; 0 for MJPG
  bool whole = true;    ///< all rows at once, not interlaced
};

/// "MJPG" for a FourCC.
std::string formatName(std::int32_t fourcc);

/// Those of the formats on offer that the configuration takes, best first. Throws common::Error naming what
/// is on offer where there is none.
std::vector<std::int32_t> usableFormats(const CameraConfig& config, const std::vector<std::int32_t>& offered);

/// Why pictures of this format cannot be used, although `fourcc` in the calibrated size was asked for; empty
/// when they can. Drivers change silently what they cannot do.
std::string objection(const FrameFormat& got, std::int32_t fourcc,
                      const common::RobotConfig::Intrinsics& lens);

}  // namespace rubble::camera
