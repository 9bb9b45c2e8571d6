#include "log_files.h"

#include <fmt/chrono.h>

#include <algorithm>
#include <numeric>

#include "common/error.h"

namespace rubble::ops_console {

namespace {

constexpr int kNumbersPerSecond = 100;
// Digits are written as 0, all else stands for itself.
constexpr std::string_view kPattern = "rubble-00000000-000000-00.lcm";

}  // namespace

std::string logFileName(common::Utime utime, int number) {
  RUBBLE_CHECK(number >= 0 && number < kNumbersPerSecond);
  const auto seconds = static_cast<std::time_t>(utime / common::kMicrosecondsPerSecond);
  return fmt::format("rubble-{:%Y%m%d-%H%M%S}-{:02}.lcm", fmt::gmtime(seconds), number);
}

bool isLogFileName(std::string_view name) {
  return std::equal(name.begin(), name.end(), kPattern.begin(), kPattern.end(),
                    [](char c, char p) { return p == '0' ? c >= '0' && c <= '9' : c == p; });
}

std::filesystem::path freeLogPath(const std::filesystem::path& dir, common::Utime utime) {
  while (true) {
    for (int number = 0; number < kNumbersPerSecond; ++number) {
      std::filesystem::path path = dir / logFileName(utime, number);
      if (!std::filesystem::exists(std::filesystem::symlink_status(path))) {
        return path;
      }
    }
    utime += common::kMicrosecondsPerSecond;
  }
}

std::vector<LogFile> listLogs(const std::filesystem::path& dir) {
  std::vector<LogFile> logs;
  for (const auto& entry : std::filesystem::directory_iterator(dir)) {
    if (isLogFileName(entry.path().filename().string()) && entry.is_regular_file()) {
      logs.push_back({entry.path(), static_cast<std::int64_t>(entry.file_size())});
    }
  }
  std::sort(logs.begin(), logs.end(), [](const LogFile& a, const LogFile& b) { return a.path < b.path; });
  return logs;
}

std::vector<std::filesystem::path> logsOverQuota(const std::vector<LogFile>& logs, std::int64_t quota_bytes,
                                                 const std::filesystem::path& current) {
  std::int64_t total = std::accumulate(logs.begin(), logs.end(), std::int64_t{0},
                                       [](std::int64_t sum, const LogFile& log) { return sum + log.bytes; });
  std::vector<std::filesystem::path> excess;
  for (const LogFile& log : logs) {
    if (total <= quota_bytes) {
      break;
    }
    if (log.path != current) {
      excess.push_back(log.path);
      total -= log.bytes;
    }
  }
  return excess;
}

}  // namespace rubble::ops_console
