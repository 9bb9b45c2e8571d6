#pragma once

#include <optional>

#include "lcm_io/codec.h"

namespace rubble::lcm_io {

/// The bytes up to the end of image that follows the last scan; empty without one. libjpeg shows what is
/// missing grey and says nothing; cameras fill their buffers up behind it.
ByteView wholeJpeg(ByteView bytes);

inline bool isWholeJpeg(ByteView bytes) { return !wholeJpeg(bytes).empty(); }

struct JpegSize {
  int width = 0;   ///< pixels
  int height = 0;  ///< pixels
};

/// What the frame header announces, without decoding; empty where there is none.
std::optional<JpegSize> jpegSize(ByteView bytes);

}  // namespace rubble::lcm_io
