#include "lcm_io/picture_decoder.h"

#include <fmt/format.h>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "common/error.h"
#include "lcm_io/jpeg.h"
#include "lcm_io/pixel_format.h"

namespace rubble::lcm_io {

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

cv::Mat decodeJpeg(const bot_core::image_t& picture, int mode) {
  // Before decoding: a damaged header could ask for gigabytes.
  const auto size = jpegSize(picture.data);
  if (!size || !isWholeJpeg(picture.data)) {
    throw common::Error(fmt::format("JPEG of {} bytes is damaged or cut off", picture.data.size()));
  }
  if (size->width != picture.width || size->height != picture.height) {
    throw common::Error(fmt::format("JPEG of {} x {} pixels in a message that says {} x {}", size->width,
                                    size->height, picture.width, picture.height));
  }
  cv::Mat decoded;
  try {
    decoded = cv::imdecode(picture.data, mode | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception&) {
    // Left empty: said below.
  }
  if (decoded.cols != picture.width || decoded.rows != picture.height) {
    throw common::Error(fmt::format("JPEG of {} bytes cannot be decoded", picture.data.size()));
  }
  return decoded;
}

void checkSize(const bot_core::image_t& picture) {
  for (const int side : {picture.width, picture.height}) {
    if (side < kSmallestSide || side > kLargestSide) {
      throw common::Error(fmt::format("picture of {} x {} pixels; {} .. {} can be handled", picture.width,
                                      picture.height, kSmallestSide, kLargestSide));
    }
  }
}

[[noreturn]] void refuseFormat(const bot_core::image_t& picture) {
  throw common::Error(fmt::format("pixel format {:#x} is none of GREY, YUYV, MJPG",
                                  static_cast<unsigned>(picture.pixelformat)));
}

}  // namespace

cv::Mat decodeGrey(const bot_core::image_t& picture) {
  checkSize(picture);
  switch (picture.pixelformat) {
    case kGrey:
      return rowsOf(picture, CV_8UC1);
    case kYuyv: {
      cv::Mat grey;
      cv::extractChannel(rowsOf(picture, CV_8UC2), grey, 0);
      return grey;
    }
    case kMjpg:
      return decodeJpeg(picture, cv::IMREAD_GRAYSCALE);
    default:
      refuseFormat(picture);
  }
}

cv::Mat decodeColour(const bot_core::image_t& picture) {
  checkSize(picture);
  cv::Mat bgr;
  switch (picture.pixelformat) {
    case kGrey:
      cv::cvtColor(rowsOf(picture, CV_8UC1), bgr, cv::COLOR_GRAY2BGR);
      return bgr;
    case kYuyv:
      cv::cvtColor(rowsOf(picture, CV_8UC2), bgr, cv::COLOR_YUV2BGR_YUYV);
      return bgr;
    case kMjpg:
      return decodeJpeg(picture, cv::IMREAD_COLOR);
    default:
      refuseFormat(picture);
  }
}

}  // namespace rubble::lcm_io
