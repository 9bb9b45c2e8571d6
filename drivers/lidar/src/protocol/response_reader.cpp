#include "protocol/response_reader.h"

#include <algorithm>

#include "common/error.h"
#include "protocol/codec.h"

namespace rubble::lidar {

namespace {

// An answer of 1440 steps with intensities takes 9 kB.
constexpr std::size_t kLongestResponse = 32 << 10;
constexpr std::size_t kStatusLine = 3;

std::optional<Response> parse(std::string_view text) {
  Response response;
  response.echo = takeLine(text);
  const std::string_view status = takeLine(text);
  if (status.size() != kStatusLine || !hasValidChecksum(status)) {
    return std::nullopt;
  }
  response.status = status.substr(0, 2);
  response.data = text;
  return response;
}

}  // namespace

std::string_view takeLine(std::string_view& text) {
  const std::size_t end = std::min(text.find('\n'), text.size());
  const std::string_view line = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  return line;
}

ResponseReader::ResponseReader() : buffer_(2 * kLongestResponse) {}

std::span<char> ResponseReader::space() {
  if (end_ - begin_ >= kLongestResponse) {
    garbage_bytes_ += static_cast<std::int64_t>(end_ - begin_);
    begin_ = end_;
  }
  if (begin_ > 0) {
    std::copy(buffer_.begin() + static_cast<std::ptrdiff_t>(begin_),
              buffer_.begin() + static_cast<std::ptrdiff_t>(end_), buffer_.begin());
    searched_ -= std::min(searched_, begin_);
    end_ -= begin_;
    begin_ = 0;
  }
  return std::span(buffer_).subspan(end_);
}

void ResponseReader::filled(std::size_t bytes) {
  RUBBLE_CHECK(bytes <= buffer_.size() - end_);
  end_ += bytes;
}

std::optional<Response> ResponseReader::next() {
  const std::string_view received(buffer_.data(), end_);
  while (true) {
    const std::size_t end = received.find("\n\n", std::max(begin_, searched_));
    if (end == std::string_view::npos) {
      searched_ = std::max(begin_, end_ > 0 ? end_ - 1 : 0);
      return std::nullopt;
    }
    const std::string_view text = received.substr(begin_, end + 1 - begin_);
    begin_ = end + 2;
    if (const auto response = parse(text)) {
      return response;
    }
    garbage_bytes_ += static_cast<std::int64_t>(text.size()) + 1;
  }
}

}  // namespace rubble::lidar
