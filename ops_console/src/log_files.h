#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "common/time.h"

// Names, order and quota of the logs in one folder. No clock: time comes as a value.
namespace rubble::ops_console {

/// `rubble-20261122-174501-00.lcm`: UTC of the first event, then a number from 0 to 99 that tells logs of
/// the same second apart. Names sort by time.
std::string logFileName(common::Utime utime, int number);

/// True for exactly the names that logFileName makes.
bool isLogFileName(std::string_view name);

/// The first free name in `dir` for a log that begins at `utime`.
std::filesystem::path freeLogPath(const std::filesystem::path& dir, common::Utime utime);

struct LogFile {
  std::filesystem::path path;
  std::int64_t bytes = 0;
};

/// The logs in `dir`, oldest first. Throws std::filesystem::filesystem_error.
std::vector<LogFile> listLogs(const std::filesystem::path& dir);

/// Which of `logs` (oldest first) must go so that the rest fits `quota_bytes`; never `current`.
std::vector<std::filesystem::path> logsOverQuota(const std::vector<LogFile>& logs, std::int64_t quota_bytes,
                                                 const std::filesystem::path& current);

}  // namespace rubble::ops_console
