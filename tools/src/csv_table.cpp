#include "csv_table.h"

#include <fmt/format.h>

#include <algorithm>

#include "common/error.h"

namespace rubble::tools {

std::vector<std::string> splitCsv(std::string_view line) {
  std::vector<std::string> values(1);
  bool is_quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (c == '"' && is_quoted && line.substr(i + 1, 1) == "\"") {
      values.back() += line[++i];
    } else if (c == '"') {
      is_quoted = !is_quoted;
    } else if (c == ',' && !is_quoted) {
      values.emplace_back();
    } else if (c != '\r') {
      values.back() += c;
    }
  }
  if (is_quoted) {
    throw common::Error("a double quote is not closed");
  }
  return values;
}

void forEachRow(const TextFile& file, std::initializer_list<const char*> columns,
                const std::function<void(const std::vector<std::string>&)>& handle) {
  std::vector<std::string> header;
  std::vector<std::size_t> places;
  forEachLine(file, [&](std::string_view line) {
    const std::vector<std::string> values = splitCsv(line);
    if (header.empty()) {
      for (const char* column : columns) {
        const auto found = std::find(values.begin(), values.end(), column);
        if (found == values.end()) {
          throw common::Error(fmt::format("the first line names no column `{}`", column));
        }
        places.push_back(static_cast<std::size_t>(found - values.begin()));
      }
      header = values;
      return;
    }
    if (values.size() != header.size()) {
      throw common::Error(fmt::format("{} values for {} columns", values.size(), header.size()));
    }
    std::vector<std::string> row;
    for (const std::size_t place : places) {
      row.push_back(values[place]);
    }
    handle(row);
  });
  if (header.empty()) {
    throw common::Error(fmt::format("{}: is empty; its first line names the columns", file.name));
  }
}

}  // namespace rubble::tools
