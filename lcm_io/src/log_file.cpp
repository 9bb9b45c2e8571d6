#include "lcm_io/log_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

namespace rubble::lcm_io {

namespace {

// Event: sync word, event number, receive time, channel length, data length (big endian), channel, data.
constexpr std::uint32_t kSyncWord = 0xEDA1DA01;
constexpr std::size_t kHeaderBytes = 28;
constexpr std::size_t kLongestChannel = 1000;
constexpr std::size_t kFlushBytes = 1 << 16;

template <typename T>
T readBigEndian(const std::uint8_t* p) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    value = value << 8 | p[i];
  }
  return static_cast<T>(value);
}

template <typename T>
void appendBigEndian(Bytes& out, T value) {
  for (int shift = 8 * (static_cast<int>(sizeof(T)) - 1); shift >= 0; shift -= 8) {
    out.push_back(static_cast<std::uint8_t>(static_cast<std::uint64_t>(value) >> shift));
  }
}

bool isHeader(const std::uint8_t* p) {
  const auto channel_bytes = readBigEndian<std::int32_t>(p + 20);
  return readBigEndian<std::uint32_t>(p) == kSyncWord && channel_bytes > 0 &&
         channel_bytes <= static_cast<std::int32_t>(kLongestChannel) &&
         readBigEndian<std::int32_t>(p + 24) >= 0;
}

}  // namespace

LogReader::LogReader(const std::filesystem::path& path) : path_(path) {
  std::error_code error;
  if (std::filesystem::is_regular_file(path, error)) {
    file_.reset(std::fopen(path.c_str(), "rb"));
  }
  if (!file_) {
    throw common::Error(fmt::format("{}: log cannot be read", path.string()));
  }
  size_ = static_cast<std::int64_t>(std::filesystem::file_size(path));
  std::array<std::uint8_t, 4> start{};
  const std::size_t n = std::fread(start.data(), 1, start.size(), file_.get());
  if (n == start.size() && readBigEndian<std::uint32_t>(start.data()) != kSyncWord) {
    throw common::Error(fmt::format("{}: not an LCM event log (see `rubble import --help`)", path.string()));
  }
  std::rewind(file_.get());
}

std::optional<LogEvent> LogReader::next() {
  if (truncated_) {
    return std::nullopt;
  }
  std::array<std::uint8_t, kHeaderBytes> header{};
  const std::size_t n = std::fread(header.data(), 1, header.size(), file_.get());
  if (n < header.size()) {
    truncated_ = n > 0;
    return std::nullopt;
  }
  if (!isHeader(header.data())) {
    throw common::Error(
        fmt::format("{}: damaged at byte {}: no event starts there", path_.string(), position_));
  }
  const auto channel_bytes = readBigEndian<std::int32_t>(header.data() + 20);
  const auto data_bytes = readBigEndian<std::int32_t>(header.data() + 24);
  const std::int64_t end = position_ + static_cast<std::int64_t>(kHeaderBytes) + channel_bytes + data_bytes;
  if (end > size_) {
    if (anotherHeaderFollows()) {
      throw common::Error(
          fmt::format("{}: damaged at byte {}: its event is longer than the log, yet others follow",
                      path_.string(), position_));
    }
    truncated_ = true;
    return std::nullopt;
  }
  LogEvent event;
  event.number = readBigEndian<std::int64_t>(header.data() + 4);
  event.utime = readBigEndian<std::int64_t>(header.data() + 12);
  event.channel.resize(static_cast<std::size_t>(channel_bytes));
  event.data.resize(static_cast<std::size_t>(data_bytes));
  if (std::fread(event.channel.data(), 1, event.channel.size(), file_.get()) != event.channel.size() ||
      std::fread(event.data.data(), 1, event.data.size(), file_.get()) != event.data.size()) {
    throw common::Error(fmt::format("{}: cannot be read at byte {}", path_.string(), position_));
  }
  position_ = end;
  return event;
}

bool LogReader::anotherHeaderFollows() {
  // What a writer appends meanwhile is none of ours.
  std::int64_t left = size_ - position_ - static_cast<std::int64_t>(kHeaderBytes);
  Bytes window;
  std::array<std::uint8_t, kFlushBytes> chunk{};
  while (left > 0) {
    const std::size_t wanted = std::min(chunk.size(), static_cast<std::size_t>(left));
    const std::size_t n = std::fread(chunk.data(), 1, wanted, file_.get());
    left = n < wanted ? 0 : left - static_cast<std::int64_t>(n);
    window.insert(window.end(), chunk.data(), chunk.data() + n);
    std::size_t at = 0;
    for (; at + kHeaderBytes <= window.size(); ++at) {
      if (isHeader(window.data() + at)) {
        return true;
      }
    }
    window.erase(window.begin(), window.begin() + static_cast<std::ptrdiff_t>(at));
  }
  return false;
}

LogWriter::LogWriter(const std::filesystem::path& path) : path_(path) {
  fd_ = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (fd_ < 0) {
    throw common::Error(fmt::format("{}: log cannot be written ({})", path.string(), std::strerror(errno)));
  }
  buffer_.reserve(2 * kFlushBytes);
}

LogWriter::~LogWriter() {
  try {
    close();
  } catch (const common::Error&) {
    // close() is the way to learn of it.
  }
}

void LogWriter::write(common::Utime utime, const std::string& channel, ByteView data) {
  RUBBLE_CHECK(!channel.empty() && channel.size() <= kLongestChannel);
  if (buffer_.size() >= kFlushBytes) {
    flushBuffer();
  }
  const std::size_t before = buffer_.size();
  appendBigEndian(buffer_, kSyncWord);
  appendBigEndian(buffer_, number_++);
  appendBigEndian(buffer_, utime);
  appendBigEndian(buffer_, static_cast<std::int32_t>(channel.size()));
  appendBigEndian(buffer_, static_cast<std::int32_t>(data.size()));
  buffer_.insert(buffer_.end(), channel.begin(), channel.end());
  buffer_.insert(buffer_.end(), data.begin(), data.end());
  bytes_ += static_cast<std::int64_t>(buffer_.size() - before);
}

void LogWriter::flushBuffer() {
  std::size_t done = 0;
  while (done < buffer_.size()) {
    const ssize_t n = ::write(fd_, buffer_.data() + done, buffer_.size() - done);
    if (n < 0 && errno == EINTR) {
      continue;
    }
    if (n < 0) {
      const int error = errno;
      // What reached the file stays; the rest is still in the buffer for another try.
      buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(done));
      throw common::Error(
          fmt::format("{}: log cannot be written ({})", path_.string(), std::strerror(error)));
    }
    done += static_cast<std::size_t>(n);
  }
  buffer_.clear();
}

void LogWriter::flush() { flushBuffer(); }

void LogWriter::sync() {
  flushBuffer();
  if (::fdatasync(fd_) != 0) {
    throw common::Error(fmt::format("{}: log cannot be synced ({})", path_.string(), std::strerror(errno)));
  }
}

void LogWriter::close() {
  if (fd_ < 0) {
    return;
  }
  const int fd = fd_;
  try {
    flushBuffer();
  } catch (...) {
    fd_ = -1;
    ::close(fd);
    throw;
  }
  fd_ = -1;
  if (::close(fd) != 0) {
    throw common::Error(fmt::format("{}: log cannot be closed ({})", path_.string(), std::strerror(errno)));
  }
}

}  // namespace rubble::lcm_io
