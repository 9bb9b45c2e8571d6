#include "picture_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <opencv2/imgcodecs.hpp>
#include <optional>
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
constexpr std::array<std::uint8_t, 2> kPlainPgmSignature = {'P', '2'};
constexpr std::array<std::uint8_t, 2> kPgmSignature = {'P', '5'};

struct Size {
  std::int64_t width = 0;   // pixels
  std::int64_t height = 0;  // pixels
};

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

bool isPng(ByteView bytes) { return startsWith(bytes, kPngSignature); }

/// The header chunk comes first.
std::optional<Size> pngSize(ByteView bytes) {
  constexpr std::size_t kWidthAt = 16;
  if (bytes.size() < kWidthAt + 8) {
    return std::nullopt;
  }
  return Size{bigEndian32(bytes.subspan(kWidthAt, 4)), bigEndian32(bytes.subspan(kWidthAt + 4, 4))};
}

/// Takes a number, and white space and comments before it; 0: there is none.
std::int64_t takeNumber(std::string_view& rest) {
  while (!rest.empty() && (std::isspace(static_cast<unsigned char>(rest[0])) != 0 || rest[0] == '#')) {
    rest.remove_prefix(rest[0] == '#' ? std::min(rest.find('\n'), rest.size()) : 1);
  }
  std::int64_t value = 0;
  const char* end = std::from_chars(rest.data(), rest.data() + rest.size(), value).ptr;
  rest.remove_prefix(static_cast<std::size_t>(end - rest.data()));
  return value;
}

/// Empty where the bytes that follow are too few for it.
std::optional<Size> pgmSize(ByteView bytes) {
  std::string_view rest(reinterpret_cast<const char*>(bytes.data()) + 2, bytes.size() - 2);
  const std::int64_t width = takeNumber(rest);
  const std::int64_t height = takeNumber(rest);
  // In a plain one a pixel is a digit and a space at least.
  const auto most =
      static_cast<std::int64_t>(startsWith(bytes, kPlainPgmSignature) ? rest.size() / 2 : rest.size());
  return width > 0 && height > 0 && width <= most / height ? std::optional(Size{width, height})
                                                           : std::nullopt;
}

/// As announced: a damaged header could ask for gigabytes.
std::optional<Size> announcedSize(ByteView bytes) {
  if (isPng(bytes)) {
    return pngSize(bytes);
  }
  if (isJpeg(bytes)) {
    const auto size = lcm_io::jpegSize(bytes);
    return size ? std::optional(Size{size->width, size->height}) : std::nullopt;
  }
  return startsWith(bytes, kPgmSignature) || startsWith(bytes, kPlainPgmSignature) ? pgmSize(bytes)
                                                                                   : std::nullopt;
}

}  // namespace

bool isJpeg(ByteView bytes) { return startsWith(bytes, kJpegSignature); }

cv::Mat decodePictureFile(const Bytes& encoded, const std::string& name, std::int64_t most_pixels) {
  if ((isJpeg(encoded) && !lcm_io::isWholeJpeg(encoded)) || (isPng(encoded) && !isWholePng(encoded))) {
    throw common::Error(
        fmt::format("{}: the picture is damaged or cut off ({} bytes)", name, encoded.size()));
  }
  const auto size = announcedSize(encoded);
  if (size && size->height > 0 && size->width > most_pixels / size->height) {
    throw common::Error(fmt::format("{}: a picture of {} x {} pixels; at most {} can be handled", name,
                                    size->width, size->height, most_pixels));
  }
  cv::Mat grey;
  if (size) {
    try {
      grey = cv::imdecode(encoded, cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION);
    } catch (const cv::Exception&) {
      // Left empty: said below.
    }
  }
  if (grey.empty()) {
    throw common::Error(fmt::format("{}: no picture that can be decoded ({} bytes); PNG, JPEG and PGM can be",
                                    name, encoded.size()));
  }
  return grey;
}

}  // namespace rubble::tools
