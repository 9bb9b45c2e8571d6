#include "picture.h"

#include <fmt/format.h>

#include <opencv2/imgcodecs.hpp>

#include "common/error.h"
#include "picture_file.h"

namespace rubble::tools {

namespace {

/// As many as the processes can handle (lcm_io/picture_decoder).
constexpr std::int64_t kMostPixels = 8192 * 8192;

}  // namespace

bot_core::image_t pictureMessage(const lcm_io::Bytes& encoded, const std::string& name, common::Utime utime) {
  const cv::Mat grey = decodePictureFile(encoded, name, kMostPixels);
  if (!isJpeg(encoded)) {
    return greyMessage(grey, utime);
  }
  bot_core::image_t message;
  message.utime = utime;
  message.width = grey.cols;
  message.height = grey.rows;
  message.row_stride = 0;
  message.pixelformat = lcm_io::kMjpg;
  message.size = static_cast<std::int32_t>(encoded.size());
  message.data = encoded;
  message.nmetadata = 0;
  return message;
}

bot_core::image_t greyMessage(const cv::Mat& grey, common::Utime utime) {
  RUBBLE_CHECK(grey.type() == CV_8UC1);
  const cv::Mat packed = grey.isContinuous() ? grey : grey.clone();
  bot_core::image_t message;
  message.utime = utime;
  message.width = packed.cols;
  message.height = packed.rows;
  message.row_stride = packed.cols;
  message.pixelformat = lcm_io::kGrey;
  message.data.assign(packed.datastart, packed.dataend);
  message.size = static_cast<std::int32_t>(message.data.size());
  message.nmetadata = 0;
  return message;
}

PictureFileContent pictureFileContent(const bot_core::image_t& message) {
  if (message.pixelformat == lcm_io::kMjpg) {
    return {message.data, ".jpg"};
  }
  if (message.pixelformat != lcm_io::kGrey) {
    throw common::Error(fmt::format("pixel format {:#x} is neither GREY nor MJPG", message.pixelformat));
  }
  if (message.width <= 0 || message.height <= 0 || message.row_stride < message.width ||
      message.data.size() <
          static_cast<std::size_t>(message.row_stride) * static_cast<std::size_t>(message.height)) {
    throw common::Error(fmt::format("{} bytes are no GREY picture of {}x{}", message.data.size(),
                                    message.width, message.height));
  }
  // cv::Mat wants a mutable pointer; imencode only reads.
  const cv::Mat grey(message.height, message.width, CV_8UC1, const_cast<std::uint8_t*>(message.data.data()),
                     static_cast<std::size_t>(message.row_stride));
  PictureFileContent content{{}, ".png"};
  RUBBLE_CHECK(cv::imencode(content.suffix, grey, content.bytes));
  return content;
}

}  // namespace rubble::tools
