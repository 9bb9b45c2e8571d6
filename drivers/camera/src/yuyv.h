#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "lcm_io/codec.h"

namespace rubble::camera {

/// Rows of pixels in a device's buffer: `row` bytes from one to the next.
struct PixelRows {
  lcm_io::ByteView bytes;
  std::size_t row = 0;
  int width = 0;
  int height = 0;
};

/// Brightness (4:2:2: all of it) and half as many of both colours in a row.
struct YuvPlanes {
  std::vector<std::uint8_t> y;
  std::vector<std::uint8_t> u;
  std::vector<std::uint8_t> v;
};

/// Splits YUYV (Y0 U Y1 V); the width is even.
void splitYuyv(const PixelRows& yuyv, YuvPlanes& planes);

/// Only the brightness, without gaps between rows.
void greyFromYuyv(const PixelRows& yuyv, std::vector<std::uint8_t>& grey);

}  // namespace rubble::camera
