#pragma once

#include <cstdint>

namespace rubble::lcm_io {

/// V4L2 FourCC as it stands in image_t.pixelformat.
constexpr std::int32_t fourCc(const char (&code)[5]) {
  return code[0] | code[1] << 8 | code[2] << 16 | code[3] << 24;
}
inline constexpr std::int32_t kGrey = fourCc("GREY");
inline constexpr std::int32_t kYuyv = fourCc("YUYV");
inline constexpr std::int32_t kMjpg = fourCc("MJPG");

}  // namespace rubble::lcm_io
