#include "picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <opencv2/imgcodecs.hpp>
#include <string_view>

#include "common/error.h"
#include "common/files.h"
#include "lcm_io/jpeg.h"

namespace rubble::tools {

namespace {

using lcm_io::Bytes;
using lcm_io::ByteView;

constexpr std::array<std::uint8_t, 8> kPngSignature = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
constexpr std::array<std::uint8_t, 2> kJpegSignature = {0xff, 0xd8};

bool startsWith(ByteView bytes, ByteView start) {
  return bytes.size() >= start.size() && std::equal(start.begin(), start.end(), bytes.begin());
}

std::uint32_t bigEndian32(ByteView bytes) {
  return static_cast<std::uint32_t>(bytes[0]) << 24 | static_cast<std::uint32_t>(bytes[1]) << 16 |
         static_cast<std::uint32_t>(bytes[2]) << 8 | bytes[3];
}

/// Every chunk's checksum holds up to IEND. libpng itself would complain on stderr or show half a picture.
bool isWholePng(ByteView bytes) {
  constexpr std::size_t kFrame = 12;  // Length, type and checksum around a chunk's data.
  for (std::size_t at = kPngSignature.size(); bytes.size() - at >= kFrame;) {
    const std::size_t length = bigEndian32(bytes.subspan(at, 4));
    if (length > bytes.size() - at - kFrame ||
        common::crc32(bytes.subspan(at + 4, length + 4)) != bigEndian32(bytes.subspan(at + 8 + length, 4))) {
      return false;
    }
    const ByteView type = bytes.subspan(at + 4, 4);
    if (std::string_view(reinterpret_cast<const char*>(type.data()), type.size()) == "IEND") {
      return true;
    }
    at += kFrame + length;
  }
  return false;
}

}  // namespace

bot_core::image_t pictureMessage(const Bytes& encoded, const std::string& name, common::Utime utime) {
  const bool jpeg = startsWith(encoded, kJpegSignature);
  const bool png = startsWith(encoded, kPngSignature);
  if ((jpeg && !lcm_io::isWholeJpeg(encoded)) || (png && !isWholePng(encoded))) {
    throw common::Error(
        fmt::format("{}: the picture is damaged or cut off ({} bytes)", name, encoded.size()));
  }
  cv::Mat grey;
  if (!encoded.empty()) {
    try {
      grey = cv::imdecode(encoded, cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION);
    } catch (const cv::Exception&) {
      // Left empty: said below.
    }
  }
  if (grey.empty()) {
    throw common::Error(fmt::format("{}: no picture that can be decoded ({} bytes)", name, encoded.size()));
  }
  if (!jpeg) {
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
