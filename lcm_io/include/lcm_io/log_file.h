#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "common/time.h"
#include "lcm_io/codec.h"

namespace rubble::lcm_io {

/// One message of an LCM event log.
struct LogEvent {
  std::int64_t number = 0;
  /// When the message was received.
  common::Utime utime = 0;
  std::string channel;
  Bytes data;
};

/// Reads LCM event logs (lcm-logger's format). LCM's own reader takes garbage for the end of the log
/// and trusts lengths; this one tells a cut-off tail from a damaged middle.
class LogReader {
 public:
  /// Throws Error when the file cannot be read or does not start like an LCM log.
  explicit LogReader(const std::filesystem::path& path);

  /// The next event; empty at the end. Throws Error naming the byte where the log is damaged.
  std::optional<LogEvent> next();

  /// True once next() met an event that the end of the file cuts off (power loss).
  bool truncated() const { return truncated_; }

  /// Bytes read so far and in all, for progress.
  std::int64_t position() const { return position_; }
  std::int64_t size() const { return size_; }

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };

  /// Whether something like an event starts in the rest of the file, which it reads.
  bool anotherHeaderFollows();

  std::filesystem::path path_;
  std::unique_ptr<std::FILE, Close> file_;
  std::int64_t position_ = 0;
  std::int64_t size_ = 0;
  bool truncated_ = false;
};

/// Writes LCM event logs; numbers the events itself.
class LogWriter {
 public:
  /// Truncates the file. Throws Error naming the path.
  explicit LogWriter(const std::filesystem::path& path);
  ~LogWriter();
  LogWriter(const LogWriter&) = delete;
  LogWriter& operator=(const LogWriter&) = delete;

  /// Throws Error naming the path when the disk refuses what was written earlier; this event is not taken
  /// then.
  void write(common::Utime utime, const std::string& channel, ByteView data);

  template <typename Message>
  void writeMessage(common::Utime utime, const std::string& channel, const Message& message) {
    write(utime, channel, encode(message));
  }

  /// Hands all to the kernel (survives this process).
  void flush();
  /// Hands all to the disk (survives power loss).
  void sync();
  /// Flushes and closes, reporting what a destructor cannot.
  void close();

  std::int64_t bytes() const { return bytes_; }

 private:
  void flushBuffer();

  std::filesystem::path path_;
  int fd_ = -1;
  Bytes buffer_;
  std::int64_t number_ = 0;
  std::int64_t bytes_ = 0;
};

}  // namespace rubble::lcm_io
