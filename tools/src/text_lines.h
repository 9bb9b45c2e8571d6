#pragma once

#include <charconv>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

#include "common/time.h"

namespace rubble::tools {

/// A text file in memory and the name that errors call it by.
struct TextFile {
  std::string name;
  std::string text;
};

/// Throws Error naming the path.
TextFile readTextFile(const std::filesystem::path& path);

/// Hands every line that is neither blank nor a `#` comment to `handle`. An Error thrown by `handle` is
/// rethrown with `file:line: ` before it, except for a last line without its newline: that one was cut
/// off (power loss, broken copy), is left out with a warning, and the rest counts.
void forEachLine(const TextFile& file, const std::function<void(std::string_view)>& handle);

/// Takes a line apart from left to right. Every function throws Error naming `what` when it is not there.
class Words {
 public:
  explicit Words(std::string_view line, std::string_view separators = " \t\r")
      : rest_(line), separators_(separators) {}

  std::string_view word(const char* what);
  /// The rest of the line without separators around it, e.g. a file name.
  std::string_view rest();

  /// Any number, "inf" and "nan" included; T is an integer, float or double.
  template <typename T>
  T any(const char* what) {
    const std::string_view text = word(what);
    T value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size()) {
      fail(what, text);
    }
    return value;
  }
  double finite(const char* what);
  /// Seconds, rounded to the microsecond.
  common::Utime seconds(const char* what);

  /// Throws Error when words are left.
  void expectEnd();

 private:
  void skipSeparators();
  [[noreturn]] static void fail(const char* what, std::string_view found);

  std::string_view rest_;
  std::string_view separators_;
};

}  // namespace rubble::tools
