#pragma once

#include <fmt/format.h>

#include <filesystem>
#include <functional>

#include "lcm_io/log_file.h"

namespace rubble::tools {

/// Hands every event of an LCM log to `handle`, with a progress bar. An Error thrown by `handle` is rethrown
/// with the log, the event's number and its channel before it. A log that is cut off within an event (power
/// loss) gives a warning. Stops early when `handle` returns false.
void forEachEvent(const std::filesystem::path& log, const char* label,
                  const std::function<bool(lcm_io::LogEvent&)>& handle);

}  // namespace rubble::tools
