#include "log_store.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "common/error.h"
#include "log_files.h"

namespace rubble::ops_console {

namespace {

constexpr std::uintmax_t kFullBelowBytes = 2 << 20;
constexpr std::int64_t kEventHeaderBytes = 28;

std::int64_t loggedBytes(const std::vector<lcm_io::RawMessage>& batch) {
  std::int64_t bytes = 0;
  for (const lcm_io::RawMessage& message : batch) {
    bytes += kEventHeaderBytes + static_cast<std::int64_t>(message.channel.size() + message.data.size());
  }
  return bytes;
}

/// Makes a new file's name survive power loss.
void syncFolder(const std::filesystem::path& dir) {
  const int fd = ::open(dir.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  const bool synced = fd >= 0 && ::fsync(fd) == 0;
  const int error = errno;
  if (fd >= 0) {
    ::close(fd);
  }
  if (!synced) {
    throw common::Error(fmt::format("{}: cannot be synced ({})", dir.string(), std::strerror(error)));
  }
}

}  // namespace

LogStore::LogStore(std::filesystem::path dir, const LogLimits& limits)
    : dir_(std::move(dir)), limits_(limits) {}

void LogStore::write(const std::vector<lcm_io::RawMessage>& batch) {
  if (batch.empty()) {
    return;
  }
  try {
    if (current_ && rotationDue(batch)) {
      current_->writer.sync();
      current_.reset();
    }
    if (!current_) {
      open(batch.front().receive_utime);
    }
    for (const lcm_io::RawMessage& message : batch) {
      current_->writer.write(message.receive_utime, message.channel, message.data);
    }
    current_->writer.flush();
    current_->good_bytes = current_->writer.bytes();
  } catch (const std::exception& e) {
    abandonCurrent();
    fail(e);
  }
}

void LogStore::sync() {
  try {
    if (current_) {
      current_->writer.sync();
    }
  } catch (const common::Error& e) {
    abandonCurrent();
    fail(e);
  }
  try {
    enforceQuota();
  } catch (const std::filesystem::filesystem_error& e) {
    fail(e);
  }
}

void LogStore::open(common::Utime utime) {
  std::filesystem::create_directories(dir_);
  current_.emplace(freeLogPath(dir_, utime), utime);
  syncFolder(dir_);
}

bool LogStore::rotationDue(const std::vector<lcm_io::RawMessage>& batch) const {
  // A clock set back far is a new log, too.
  const common::Utime age = batch.front().receive_utime - current_->begin_utime;
  return std::abs(age) >= limits_.rotate_interval ||
         current_->good_bytes + loggedBytes(batch) > limits_.rotate_bytes;
}

/// Leaves the current file with whole events only, or removes it when it holds none.
void LogStore::abandonCurrent() {
  if (!current_) {
    return;
  }
  const std::filesystem::path path = current_->path;
  const auto good_bytes = static_cast<std::uintmax_t>(current_->good_bytes);
  current_.reset();
  // Where the disk refuses even this, the readers still stop at the cut event.
  std::error_code ignored;
  if (good_bytes == 0) {
    std::filesystem::remove(path, ignored);
  } else {
    std::filesystem::resize_file(path, good_bytes, ignored);
  }
}

void LogStore::enforceQuota() {
  if (!std::filesystem::exists(dir_)) {
    return;
  }
  const std::filesystem::path none;
  for (const auto& path :
       logsOverQuota(listLogs(dir_), limits_.quota_bytes, current_ ? current_->path : none)) {
    std::filesystem::remove(path);
  }
}

void LogStore::fail(const std::exception& cause) const {
  std::error_code unknown;
  const std::filesystem::space_info space = std::filesystem::space(dir_, unknown);
  if (!unknown && space.available < kFullBelowBytes) {
    throw common::Error(fmt::format("disk full: {} has {} kB left; free space or lower ops_console.quota_mb",
                                    dir_.string(), space.available / 1024));
  }
  throw common::Error(fmt::format("{}; check the disk and ops_console.log_dir", cause.what()));
}

}  // namespace rubble::ops_console
