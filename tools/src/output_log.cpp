#include "output_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <system_error>
#include <utility>

#include "common/error.h"
#include "report.h"

namespace rubble::tools {

OutputLog::OutputLog(std::filesystem::path path, common::Utime window)
    : path_(std::move(path)), part_(path_.string() + ".part"), window_(window), writer_(part_) {}

OutputLog::~OutputLog() {
  // Gone already when finish() renamed it.
  std::error_code ignored;
  std::filesystem::remove(part_, ignored);
}

void OutputLog::hold(common::Utime utime, const std::string& channel, lcm_io::Bytes data) {
  held_.emplace(utime, Event{channel, std::move(data)});
  ++count_[channel];
  first_utime_ = std::min(first_utime_, utime);
  last_utime_ = std::max(last_utime_, utime);
  flushBefore(last_utime_ - window_);
}

void OutputLog::flushBefore(common::Utime utime) {
  while (!held_.empty() && held_.begin()->first < utime) {
    const auto first = held_.begin();
    late_ += first->first < written_utime_ ? 1 : 0;
    written_utime_ = std::max(written_utime_, first->first);
    writer_.write(first->first, first->second.channel, first->second.data);
    held_.erase(first);
  }
}

void OutputLog::finish() {
  flushBefore(std::numeric_limits<common::Utime>::max());
  writer_.close();
  std::error_code error;
  std::filesystem::rename(part_, path_, error);
  if (error) {
    throw common::Error(fmt::format("{}: cannot be written ({})", path_.string(), error.message()));
  }
  std::string summary;
  for (const auto& [channel, count] : count_) {
    fmt::format_to(std::back_inserter(summary), "{} {}, ", count, channel);
  }
  fmt::print("{}: {}{:.1f} s\n", path_.string(), summary,
             count_.empty() ? 0.0 : common::secondsFromUtime(last_utime_ - first_utime_));
  if (late_ > 0) {
    warn(fmt::format("{}: {} messages are out of time order by more than {:.0f} s", path_.string(), late_,
                     common::secondsFromUtime(window_)));
  }
}

}  // namespace rubble::tools
