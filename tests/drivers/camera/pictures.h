#pragma once

#include <cstdint>
#include <vector>

#include "camera_config.h"
#include "jpeg_encoder.h"

namespace rubble::camera {

inline constexpr int kWidth = 96;
inline constexpr int kHeight = 64;

/// Brightness and colours that rise slowly, so that JPEG keeps them; `row` bytes from one row to the next.
inline std::vector<std::uint8_t> yuyvPicture(std::size_t row = 2 * kWidth) {
  std::vector<std::uint8_t> bytes(row * kHeight, 0xee);
  for (std::size_t y = 0; y < kHeight; ++y) {
    for (std::size_t x = 0; x < kWidth; ++x) {
      bytes[y * row + 2 * x] = static_cast<std::uint8_t>(40 + x + y);
      bytes[y * row + 2 * x + 1] = static_cast<std::uint8_t>(x % 2 == 0 ? 90 + y / 2 : 160 - y / 2);
    }
  }
  return bytes;
}

inline std::vector<std::uint8_t> greyPicture(std::size_t row = kWidth) {
  std::vector<std::uint8_t> bytes(row * kHeight, 0xee);
  for (std::size_t y = 0; y < kHeight; ++y) {
    for (std::size_t x = 0; x < kWidth; ++x) {
      bytes[y * row + x] = static_cast<std::uint8_t>(40 + x + y);
    }
  }
  return bytes;
}

inline std::vector<std::uint8_t> jpegPicture() {
  const std::vector<std::uint8_t> yuyv = yuyvPicture();
  JpegEncoder encoder(90);
  const lcm_io::ByteView jpeg = encoder.encodeYuyv({yuyv, 2 * kWidth, kWidth, kHeight});
  return {jpeg.begin(), jpeg.end()};
}

inline CameraSetup smallSetup() {
  CameraSetup setup;
  setup.camera.device = "/dev/v4l/by-path/front";
  setup.lens.width = kWidth;
  setup.lens.height = kHeight;
  setup.lens.rate = 25.0;
  return setup;
}

}  // namespace rubble::camera
