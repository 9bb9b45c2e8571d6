#pragma once

#include <optional>

#include "lcm_io/codec.h"

namespace rubble::lcm_io {

/// Whether the last scan is followed by an end of image. libjpeg shows what is missing grey and says nothing.
bool isWholeJpeg(ByteView bytes);

struct JpegSize {
  int width = 0;   ///< pixels
  int height = 0;  ///< pixels
};

/// What the frame header announces, without decoding; empty where there is none.
std::optional<JpegSize> jpegSize(ByteView bytes);

}  // namespace rubble::lcm_io
