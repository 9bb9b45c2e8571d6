#include "frame_format.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "common/error.h"
#include "lcm_io/pixel_format.h"

namespace rubble::camera {

namespace {

/// Bytes of a pixel; 0 where it has no place of its own.
std::size_t pixelBytes(std::int32_t fourcc) {
  return fourcc == lcm_io::kGrey ? 1 : fourcc == lcm_io::kYuyv ? 2 : 0;
}

}  // namespace

std::string formatName(std::int32_t fourcc) {
  std::string name;
  for (int shift = 0; shift < 32; shift += 8) {
    const auto letter = static_cast<char>(fourcc >> shift & 0x7f);
    name += letter > ' ' ? letter : '_';
  }
  return name;
}

std::vector<std::int32_t> usableFormats(const CameraConfig& config,
                                        const std::vector<std::int32_t>& offered) {
  std::vector<std::int32_t> usable;
  for (const std::int32_t fourcc : {lcm_io::kMjpg, lcm_io::kYuyv, lcm_io::kGrey}) {
    const bool wanted = config.format == "auto" ? config.wire == "jpeg" || fourcc != lcm_io::kMjpg
                                                : config.format == formatName(fourcc);
    if (wanted && std::find(offered.begin(), offered.end(), fourcc) != offered.end()) {
      usable.push_back(fourcc);
    }
  }
  if (usable.empty()) {
    std::vector<std::string> names(offered.size());
    std::transform(offered.begin(), offered.end(), names.begin(), formatName);
    throw common::Error(fmt::format("offers {}, which camera.format = {} with camera.wire = {} cannot use",
                                    names.empty() ? "no format" : fmt::format("{}", fmt::join(names, ", ")),
                                    config.format, config.wire));
  }
  return usable;
}

std::string objection(const FrameFormat& got, std::int32_t fourcc,
                      const common::RobotConfig::Intrinsics& lens) {
  if (got.fourcc != fourcc) {
    return fmt::format("gives {} when asked for {}; set camera.format to one it has", formatName(got.fourcc),
                       formatName(fourcc));
  }
  if (got.width != lens.width || got.height != lens.height) {
    return fmt::format(
        "gives {} x {} pixels in {}, but robot.camera is calibrated for {} x {}; set robot.camera to a size "
        "it has and calibrate for it",
        got.width, got.height, formatName(fourcc), lens.width, lens.height);
  }
  if (!got.whole) {
    return fmt::format("interlaces its {} pictures; set camera.format to another", formatName(fourcc));
  }
  if (got.row < pixelBytes(fourcc) * static_cast<std::size_t>(got.width)) {
    return fmt::format("says that rows of {} {} pixels have {} bytes; set camera.format to another",
                       got.width, formatName(fourcc), got.row);
  }
  return {};
}

}  // namespace rubble::camera
