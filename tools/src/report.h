#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace rubble::tools {

/// One line on stderr for what the user should know although the work goes on.
void warn(std::string_view text);

/// Named results of an evaluation, in the order they were added; keys are snake_case with the unit at
/// their end.
class Report {
 public:
  /// Not finite becomes JSON's null.
  void add(std::string key, double value);
  void add(std::string key, int value);
  void add(std::string key, std::string_view value);

  /// One JSON object on several lines.
  std::string json() const;
  /// A table for people: key and value on each line.
  std::string text() const;
  /// Writes one of the two to stdout.
  void print(bool as_json) const;

 private:
  std::vector<std::pair<std::string, std::string>> values_;
};

}  // namespace rubble::tools
