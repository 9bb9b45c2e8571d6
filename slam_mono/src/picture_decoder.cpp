#include "picture_decoder.h"

#include <fmt/format.h>

#include <opencv2/imgcodecs.hpp>

#include "common/error.h"
#include "lcm_io/jpeg.h"
#include "lcm_io/pixel_format.h"

namespace rubble::slam_mono {

namespace {

/// Features need some room; OpenCV and the arithmetic here stay far from overflow.
constexpr int kSmallestSide = 64;
constexpr int kLargestSide = 8192;

/// The message's rows, `type` per pixel. cv::Mat wants a mutable pointer; nobody writes.
cv::Mat rowsOf(const bot_core::image_t& picture, int type) {
  const std::int64_t row = static_cast<std::int64_t>(picture.width) * CV_ELEM_SIZE(type);
  const std::int64_t needed = static_cast<std::int64_t>(picture.row_stride) * (picture.height - 1) + row;
  if (picture.row_stride < row || static_cast<std::int64_t>(picture.data.size()) < needed) {
    throw common::Error(fmt::format("{} bytes in rows of {} are no picture of {} x {} pixels",
                                    picture.data.size(), picture.row_stride, picture.width, picture.height));
  }
  return {picture.height, picture.width, type, const_cast<std::uint8_t*>(picture.data.data()),
          static_cast<std::size_t>(picture.row_stride)};
}

cv::Mat decodeJpeg(const bot_core::image_t& picture) {
  // Before decoding: a damaged header could ask for gigabytes.
  const auto size = lcm_io::jpegSize(picture.data);
  if (!size || !lcm_io::isWholeJpeg(picture.data)) {
    throw common::Error(fmt::format("JPEG of {} bytes is damaged or cut off", picture.data.size()));
  }
  if (size->width != picture.width || size->height != picture.height) {
    throw common::Error(fmt::format("JPEG of {} x {} pixels in a message that says {} x {}", size->width,
                                    size->height, picture.width, picture.height));
  }
  cv::Mat grey;
  try {
    grey = cv::imdecode(picture.data, cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception&) {
    // Left empty: said below.
  }
  if (grey.cols != picture.width || grey.rows != picture.height) {
    throw common::Error(fmt::format("JPEG of {} bytes cannot be decoded", picture.data.size()));
  }
  return grey;
}

}  // namespace

cv::Mat decodePicture(const bot_core::image_t& picture) {
  for (const int side : {picture.width, picture.height}) {
    if (side < kSmallestSide || side > kLargestSide) {
      throw common::Error(fmt::format("picture of {} x {} pixels; {} .. {} can be handled", picture.width,
                                      picture.height, kSmallestSide, kLargestSide));
    }
  }
  if (picture.pixelformat == lcm_io::kGrey) {
    return rowsOf(picture, CV_8UC1);
  }
  if (picture.pixelformat == lcm_io::kYuyv) {
    cv::Mat grey;
    cv::extractChannel(rowsOf(picture, CV_8UC2), grey, 0);
    return grey;
  }
  if (picture.pixelformat == lcm_io::kMjpg) {
    return decodeJpeg(picture);
  }
  throw common::Error(fmt::format("pixel format {:#x} is none of GREY, YUYV, MJPG",
                                  static_cast<unsigned>(picture.pixelformat)));
}

}  // namespace rubble::slam_mono
