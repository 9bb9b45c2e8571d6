#pragma once

#include <memory>
#include <vector>

#include "yuyv.h"

namespace rubble::camera {

/// JPEG by libjpeg-turbo, into a buffer that is kept.
class JpegEncoder {
 public:
  /// `quality` 1 .. 100.
  explicit JpegEncoder(int quality);

  /// Valid until the next call.
  lcm_io::ByteView encodeGrey(const PixelRows& grey);
  lcm_io::ByteView encodeYuyv(const PixelRows& yuyv);

 private:
  void reserve(const PixelRows& pixels);

  struct Close {
    void operator()(void* handle) const;
  };

  std::unique_ptr<void, Close> handle_;
  int quality_;
  YuvPlanes planes_;
  std::vector<std::uint8_t> jpeg_;
};

}  // namespace rubble::camera
