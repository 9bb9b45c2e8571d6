#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <string>

#include "lcm_io/codec.h"

namespace rubble::tools {

bool isJpeg(lcm_io::ByteView bytes);

/// The brightness of a whole PNG, JPEG or PGM, CV_8UC1. Throws Error naming `name` for anything else, for
/// what is damaged or cut off, and for more than `most_pixels`.
cv::Mat decodePictureFile(const lcm_io::Bytes& encoded, const std::string& name, std::int64_t most_pixels);

}  // namespace rubble::tools
