#include "lcm_io/log_bus.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "common/error.h"

namespace rubble::lcm_io {

namespace {

std::string pathOf(const std::string& url) {
  const std::string_view rest = std::string_view(url).substr(std::string_view(LogBus::kScheme).size());
  const std::string_view path = rest.substr(0, rest.find('?'));
  if (const std::string_view query = rest.substr(path.size()); !query.empty() && query != "?speed=0") {
    throw common::Error(
        fmt::format("--lcm-url {}: a log is read as fast as it is handled; write {}{}?speed=0", url,
                    LogBus::kScheme, path));
  }
  return std::string(path);
}

}  // namespace

LogBus::LogBus(const std::string& url) : log_(pathOf(url)) {}

bool LogBus::dispatch(std::chrono::milliseconds /*timeout*/) {
  auto event = ended_ ? std::nullopt : log_.next();
  if (!event) {
    ended_ = true;
    return false;
  }
  now_ = std::max(now_, event->utime);
  deliver({std::move(event->channel), event->utime, std::move(event->data)});
  return true;
}

}  // namespace rubble::lcm_io
