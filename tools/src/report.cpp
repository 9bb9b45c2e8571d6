#include "report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

namespace rubble::tools {

void warn(std::string_view text) { fmt::print(stderr, "rubble: warning: {}\n", text); }

void printReport(const nlohmann::ordered_json& report, bool as_json) {
  if (as_json) {
    fmt::print("{}\n", report.dump(2));
    return;
  }
  std::size_t width = 0;
  for (const auto& item : report.items()) {
    width = std::max(width, item.key().size());
  }
  for (const auto& [key, value] : report.items()) {
    fmt::print("{:<{}}  {}\n", key, width,
               value.is_number_float() ? fmt::format("{:.6g}", value.get<double>()) : value.dump());
  }
}

}  // namespace rubble::tools
