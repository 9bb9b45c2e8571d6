#pragma once

#include <bot_core/image_t.hpp>
#include <opencv2/core/mat.hpp>

namespace rubble::lcm_io {

/// The brightness of a picture, CV_8UC1, from GREY, YUYV or MJPG (any JPEG). May look into the message's own
/// bytes: valid as long as the message. Throws common::Error for another pixel format, a size that the bytes
/// do not fit, and a JPEG that is damaged, cut off or of another size than the message says.
cv::Mat decodeGrey(const bot_core::image_t& picture);

/// The same in colour, CV_8UC3 BGR; a grey picture has three equal channels.
cv::Mat decodeColour(const bot_core::image_t& picture);

}  // namespace rubble::lcm_io
