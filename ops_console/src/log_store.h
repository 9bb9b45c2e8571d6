#pragma once

#include <filesystem>
#include <optional>

#include "common/time.h"
#include "lcm_io/log_file.h"
#include "log_sink.h"

namespace rubble::ops_console {

struct LogLimits {
  std::int64_t quota_bytes = 0;
  std::int64_t rotate_bytes = 0;
  common::Utime rotate_interval = 0;
};

/// The logs on the disk: rotation by size and by the time of the messages, quota, and files that hold whole
/// events only. A file is opened for the first message it shall hold; after an error a new one is begun.
class LogStore : public LogSink {
 public:
  LogStore(std::filesystem::path dir, const LogLimits& limits);

  /// The batch is in the kernel when this returns; when it throws common::Error none of it is in a log.
  void write(const std::vector<lcm_io::RawMessage>& batch) override;
  /// What was written is on the disk when this returns, and the quota holds. Throws common::Error.
  void sync() override;

 private:
  struct Current {
    Current(const std::filesystem::path& file, common::Utime utime)
        : path(file), begin_utime(utime), writer(file) {}

    std::filesystem::path path;
    common::Utime begin_utime;
    lcm_io::LogWriter writer;
    /// Length that ends with a whole event of the last batch written.
    std::int64_t good_bytes = 0;
  };

  void open(common::Utime utime);
  bool rotationDue(const std::vector<lcm_io::RawMessage>& batch) const;
  void abandonCurrent();
  void enforceQuota();
  [[noreturn]] void fail(const std::exception& cause) const;

  const std::filesystem::path dir_;
  const LogLimits limits_;
  std::optional<Current> current_;
};

}  // namespace rubble::ops_console
