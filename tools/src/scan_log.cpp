#include "scan_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "common/error.h"
#include "lcm_io/channels.h"

namespace rubble::tools {

namespace {

constexpr std::size_t kScansForTheRate = 41;
// More of either would not fit into SCIP's numbers.
constexpr int kMostBeams = 9'999;
constexpr double kSlowest = 0.1;
constexpr double kFastest = 1'000.0;

/// The middle interval, which gaps do not move.
double rateOf(const std::vector<common::Utime>& utimes) {
  std::vector<common::Utime> intervals;
  for (std::size_t i = 1; i < utimes.size(); ++i) {
    intervals.push_back(std::max<common::Utime>(1, utimes[i] - utimes[i - 1]));
  }
  const auto middle = intervals.begin() + static_cast<std::ptrdiff_t>(intervals.size() / 2);
  std::nth_element(intervals.begin(), middle, intervals.end());
  return std::clamp(1e6 / static_cast<double>(*middle), kSlowest, kFastest);
}

}  // namespace

ScanLog::ScanLog(std::filesystem::path log, bool loop) : path_(std::move(log)), loop_(loop), log_(path_) {
  std::vector<common::Utime> utimes;
  while (utimes.size() < kScansForTheRate) {
    const auto scan = read();
    if (!scan) {
      break;
    }
    if (utimes.empty()) {
      first_utime_ = scan->utime;
      model_ = {.beams = scan->nranges, .rad0 = scan->rad0, .radstep = scan->radstep};
    }
    utimes.push_back(scan->utime);
  }
  if (utimes.size() < 2) {
    throw common::Error(fmt::format("{}: holds fewer than two messages on SCAN", path_.string()));
  }
  if (model_.beams < 2 || model_.beams > kMostBeams || !(model_.radstep > 0.0) || model_.rad0 > 0.0) {
    throw common::Error(
        fmt::format("{}: no Hokuyo scans like this: {} beams from {} rad in steps of {} rad "
                    "(counter-clockwise, from the right)",
                    path_.string(), model_.beams, model_.rad0, model_.radstep));
  }
  model_.rate = rateOf(utimes);
  log_.emplace(path_);
}

bool ScanLog::next(lidar::EmulatedScan& scan) {
  auto message = read();
  if (!message && loop_) {
    log_.emplace(path_);
    round_begin_ = last_ + std::llround(1e6 / model_.rate);
    message = read();
  }
  if (!message) {
    return false;
  }
  if (message->nranges != model_.beams) {
    throw common::Error(fmt::format("{}: a scan of {} beams among those of {}", path_.string(),
                                    message->nranges, model_.beams));
  }
  last_ = std::max(last_, round_begin_ + message->utime - first_utime_);
  scan.since_first = std::chrono::microseconds(last_);
  scan.ranges.swap(message->ranges);
  scan.intensities.swap(message->intensities);
  return true;
}

std::optional<bot_core::planar_lidar_t> ScanLog::read() {
  while (const auto event = log_->next()) {
    if (event->channel == lcm_io::channel::kScan) {
      return lcm_io::decode<bot_core::planar_lidar_t>(event->data);
    }
  }
  return std::nullopt;
}

}  // namespace rubble::tools
