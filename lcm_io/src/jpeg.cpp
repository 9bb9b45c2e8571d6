#include "lcm_io/jpeg.h"

namespace rubble::lcm_io {

namespace {

constexpr std::uint8_t kStartOfImage = 0xd8;
constexpr std::uint8_t kEndOfImage = 0xd9;
constexpr std::uint8_t kStartOfScan = 0xda;

/// Position of the last marker 0xff `code`, or the size.
std::size_t lastMarker(ByteView bytes, std::uint8_t code) {
  for (std::size_t i = bytes.size(); i-- > 1;) {
    if (bytes[i] == code && bytes[i - 1] == 0xff) {
      return i - 1;
    }
  }
  return bytes.size();
}

/// SOF0 .. SOF15, among which lie the tables DHT, JPG and DAC (ITU-T T.81, table B.1).
bool isFrameHeader(std::uint8_t code) {
  return code >= 0xc0 && code <= 0xcf && code != 0xc4 && code != 0xc8 && code != 0xcc;
}

int bigEndian16(ByteView bytes) { return bytes[0] << 8 | bytes[1]; }

}  // namespace

ByteView wholeJpeg(ByteView bytes) {
  const std::size_t scan = lastMarker(bytes, kStartOfScan);
  const std::size_t end = lastMarker(bytes, kEndOfImage);
  return scan < end && end < bytes.size() ? bytes.first(end + 2) : ByteView();
}

std::optional<JpegSize> jpegSize(ByteView bytes) {
  if (bytes.size() < 2 || bytes[0] != 0xff || bytes[1] != kStartOfImage) {
    return std::nullopt;
  }
  // 0xff, code, length of the segment (itself included); a frame header goes on with precision, height,
  // width.
  constexpr std::size_t kHeader = 9;
  for (std::size_t at = 2; at + kHeader <= bytes.size();) {
    const ByteView segment = bytes.subspan(at);
    if (segment[0] != 0xff) {
      return std::nullopt;
    }
    if (segment[1] == 0xff) {  // Fill byte.
      ++at;
      continue;
    }
    if (isFrameHeader(segment[1])) {
      return JpegSize{bigEndian16(segment.subspan(7)), bigEndian16(segment.subspan(5))};
    }
    const int length = bigEndian16(segment.subspan(2));
    if (segment[1] == kStartOfScan || length < 2) {
      return std::nullopt;
    }
    at += 2 + static_cast<std::size_t>(length);
  }
  return std::nullopt;
}

}  // namespace rubble::lcm_io
