#include "health_watch.h"

#include <fmt/format.h>

namespace rubble::ops_console {

namespace {

constexpr common::Utime kSilence = 3 * common::kMicrosecondsPerSecond;

}  // namespace

void HealthWatch::update(const std::string& process, const std::string& complaint, common::Utime now) {
  processes_[process] = {now, complaint};
}

std::vector<std::string> HealthWatch::problems(common::Utime now) const {
  std::vector<std::string> problems;
  for (const auto& [process, latest] : processes_) {
    if (now - latest.heard_utime > kSilence) {
      problems.push_back(fmt::format("{} is silent for {} s", process,
                                     (now - latest.heard_utime) / common::kMicrosecondsPerSecond));
    } else if (!latest.complaint.empty()) {
      problems.push_back(fmt::format("{} {}", process, latest.complaint));
    }
  }
  return problems;
}

}  // namespace rubble::ops_console
