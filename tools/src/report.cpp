#include "report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace rubble::tools {

namespace {

std::string quoted(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (static_cast<unsigned char>(c) < 0x20) {
      out += fmt::format("\\u{:04x}", static_cast<unsigned char>(c));
    } else {
      out += c;
    }
  }
  return out + '"';
}

}  // namespace

void warn(std::string_view text) { fmt::print(stderr, "rubble: warning: {}\n", text); }

void Report::add(std::string key, double value) {
  values_.emplace_back(std::move(key), std::isfinite(value) ? fmt::format("{:.9g}", value) : "null");
}

void Report::add(std::string key, int value) {
  values_.emplace_back(std::move(key), fmt::format("{}", value));
}

void Report::add(std::string key, std::string_view value) {
  values_.emplace_back(std::move(key), quoted(value));
}

std::string Report::json() const {
  std::string out = "{";
  const char* separator = "\n";
  for (const auto& [key, value] : values_) {
    out += fmt::format("{}  {}: {}", separator, quoted(key), value);
    separator = ",\n";
  }
  return out + "\n}\n";
}

std::string Report::text() const {
  std::size_t width = 0;
  for (const auto& [key, value] : values_) {
    width = std::max(width, key.size());
  }
  std::string out;
  for (const auto& [key, value] : values_) {
    out += fmt::format("{:<{}}  {}\n", key, width, value);
  }
  return out;
}

void Report::print(bool as_json) const { fmt::print("{}", as_json ? json() : text()); }

}  // namespace rubble::tools
