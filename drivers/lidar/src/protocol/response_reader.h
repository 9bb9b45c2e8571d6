#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace rubble::lidar {

/// One answer of the sensor (SCIP 2.0 section 7): the command's echo, two characters of status whose checksum
/// is right, and the lines that follow, each ended by a line feed and not checked yet.
struct Response {
  std::string_view echo;
  std::string_view status;
  std::string_view data;
};

/// Takes the first line, without its line feed, off the text.
std::string_view takeLine(std::string_view& text);

/// Cuts the sensor's byte stream into answers, which end with an empty line. Bytes that are no answer are
/// skipped up to the next empty line and counted.
class ResponseReader {
 public:
  ResponseReader();

  /// Where the next bytes go, never empty; what next() has returned is gone.
  std::span<char> space();
  /// That many bytes of space() have been filled.
  void filled(std::size_t bytes);

  /// Valid until space() is called. Empty when more bytes are needed.
  std::optional<Response> next();

  std::int64_t garbageBytes() const { return garbage_bytes_; }

 private:
  std::vector<char> buffer_;
  std::size_t begin_ = 0;     // of what next() has not returned yet
  std::size_t searched_ = 0;  // up to here there is no end of an answer
  std::size_t end_ = 0;       // of the bytes received
  std::int64_t garbage_bytes_ = 0;
};

}  // namespace rubble::lidar
