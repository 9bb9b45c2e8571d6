#include "text_lines.h"

#include <fmt/format.h>

#include <cmath>

#include "common/error.h"
#include "common/files.h"
#include "report.h"

namespace rubble::tools {

namespace {

constexpr double kLatestSeconds = 1e11;  // Year 5138: anything later is no time.
constexpr std::size_t kQuotedCharacters = 40;

}  // namespace

TextFile readTextFile(const std::filesystem::path& path) {
  const std::vector<std::uint8_t> bytes = common::readFile(path);
  return {path.string(), std::string(bytes.begin(), bytes.end())};
}

void forEachLine(const TextFile& file, const std::function<void(std::string_view)>& handle) {
  const std::string_view text = file.text;
  std::size_t begin = 0;
  for (int number = 1; begin < text.size(); ++number) {
    const std::size_t newline = text.find('\n', begin);
    const std::string_view line = text.substr(begin, newline - begin);
    begin = newline == std::string_view::npos ? text.size() : newline + 1;
    const std::size_t first = line.find_first_not_of(" \t\r");
    if (first == std::string_view::npos || line[first] == '#') {
      continue;
    }
    try {
      handle(line);
    } catch (const common::Error& e) {
      const std::string where = fmt::format("{}:{}: {}", file.name, number, e.what());
      if (newline != std::string_view::npos) {
        throw common::Error(where);
      }
      warn(where + "; the file ends within this line, which is left out");
    }
  }
}

void Words::skipSeparators() {
  const std::size_t begin = rest_.find_first_not_of(separators_);
  rest_.remove_prefix(begin == std::string_view::npos ? rest_.size() : begin);
}

std::string_view Words::word(const char* what) {
  skipSeparators();
  if (rest_.empty()) {
    throw common::Error(fmt::format("the line ends before its {}", what));
  }
  const std::string_view found = rest_.substr(0, rest_.find_first_of(separators_));
  rest_.remove_prefix(found.size());
  return found;
}

std::string_view Words::rest() {
  skipSeparators();
  return rest_.substr(0, rest_.find_last_not_of(separators_) + 1);
}

double Words::finite(const char* what) {
  skipSeparators();
  const std::string_view before = rest_;
  const auto value = any<double>(what);
  if (!std::isfinite(value)) {
    fail(what, before.substr(0, before.size() - rest_.size()));
  }
  return value;
}

common::Utime Words::seconds(const char* what) {
  const double value = finite(what);
  if (std::abs(value) > kLatestSeconds) {
    fail(what, std::to_string(value));
  }
  return common::utimeFromSeconds(value);
}

void Words::expectEnd() {
  if (!rest().empty()) {
    throw common::Error(
        fmt::format("the line goes on after its last field: `{}`", rest().substr(0, kQuotedCharacters)));
  }
}

void Words::fail(const char* what, std::string_view found) {
  std::string shown(found.substr(0, kQuotedCharacters));
  for (char& c : shown) {
    if (static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) > 0x7e) {
      c = '?';
    }
  }
  throw common::Error(fmt::format("`{}` is no {}", shown, what));
}

}  // namespace rubble::tools
