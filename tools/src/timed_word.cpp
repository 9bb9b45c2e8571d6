#include "timed_word.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "common/error.h"

namespace rubble::tools {

TimedWord parseTimedWord(const std::string& text, const char* example) {
  const std::size_t at = std::min(text.find('@'), text.size());
  const std::string seconds = text.substr(std::min(at + 1, text.size()));
  double after = -1.0;
  const auto [end, error] = std::from_chars(seconds.data(), seconds.data() + seconds.size(), after);
  if (error != std::errc() || end != seconds.data() + seconds.size() || !(after >= 0.0 && after < 1e6)) {
    throw common::Error(fmt::format("--fault {}: write KIND@SECONDS, e.g. {}", text, example));
  }
  return {text.substr(0, at), std::chrono::duration_cast<std::chrono::steady_clock::duration>(
                                  std::chrono::duration<double>(after))};
}

}  // namespace rubble::tools
