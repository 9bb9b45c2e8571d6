#pragma once

#include <bot_core/image_t.hpp>

#include "frame_format.h"
#include "jpeg_encoder.h"

namespace rubble::camera {

/// A device's buffer as CAMERA's message: MJPG as it is, YUYV and GREY compressed or as raw grey.
class PictureMaker {
 public:
  PictureMaker(const CameraConfig& config, const FrameFormat& format);

  /// Fills all but utime and metadata. False for bytes that are no whole picture of the format.
  bool make(lcm_io::ByteView bytes, bot_core::image_t& picture);

 private:
  FrameFormat format_;
  bool raw_;
  JpegEncoder encoder_;
};

}  // namespace rubble::camera
