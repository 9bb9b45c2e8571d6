#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string_view>

namespace rubble::tools {

/// One line on stderr for what the user should know although the work goes on.
void warn(std::string_view text);

/// Results on stdout, in the order they were added: one JSON object, or a table for people with a key and its
/// value on each line. Keys are snake_case with the unit at their end; what is not finite is null.
void printReport(const nlohmann::ordered_json& report, bool as_json);

}  // namespace rubble::tools
