#pragma once

#include <bot_core/image_t.hpp>
#include <opencv2/core/mat.hpp>
#include <string>

#include "common/time.h"
#include "lcm_io/codec.h"
#include "lcm_io/pixel_format.h"

namespace rubble::tools {

/// The picture of an encoded file: a JPEG's bytes untouched as MJPG; PNG and PGM decoded to GREY, lossless
/// but for colour. Throws Error naming `name` for bytes that are no whole picture.
bot_core::image_t pictureMessage(const lcm_io::Bytes& encoded, const std::string& name, common::Utime utime);

/// A CV_8UC1 matrix as a GREY message.
bot_core::image_t greyMessage(const cv::Mat& grey, common::Utime utime);

/// File contents for a message and the suffix they go by: MJPG ".jpg" untouched, GREY ".png". Throws Error
/// for other pixel formats and for a size that does not fit.
struct PictureFileContent {
  lcm_io::Bytes bytes;
  std::string suffix;
};
PictureFileContent pictureFileContent(const bot_core::image_t& message);

}  // namespace rubble::tools
