#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <string>

#include "common/time.h"
#include "lcm_io/codec.h"
#include "lcm_io/log_file.h"

namespace rubble::tools {

/// An LCM log that an importer makes. Messages may come out of order by up to `window`; the log has them
/// in time order (equal times in the order they came). The file appears under its name when finished:
/// a failed import leaves nothing behind.
class OutputLog {
 public:
  /// The window that sorts the whole file.
  static constexpr common::Utime kWholeFile = std::numeric_limits<common::Utime>::max() / 2;

  /// Throws Error naming the path when the file cannot be written.
  OutputLog(std::filesystem::path path, common::Utime window);
  ~OutputLog();
  OutputLog(const OutputLog&) = delete;
  OutputLog& operator=(const OutputLog&) = delete;

  template <typename Message>
  void write(common::Utime utime, const std::string& channel, const Message& message) {
    hold(utime, channel, lcm_io::encode(message));
  }

  /// Completes the file and says on stdout what is in it; warns of messages that came too late to be in
  /// order. Throws Error when the disk refuses.
  void finish();

 private:
  struct Event {
    std::string channel;
    lcm_io::Bytes data;
  };

  void hold(common::Utime utime, const std::string& channel, lcm_io::Bytes data);
  void flushBefore(common::Utime utime);

  const std::filesystem::path path_;
  const std::filesystem::path part_;
  const common::Utime window_;
  lcm_io::LogWriter writer_;
  std::multimap<common::Utime, Event> held_;
  common::Utime written_utime_ = std::numeric_limits<common::Utime>::min();
  std::int64_t late_ = 0;
  std::map<std::string, std::int64_t> count_;
  common::Utime first_utime_ = std::numeric_limits<common::Utime>::max();
  common::Utime last_utime_ = std::numeric_limits<common::Utime>::min();
};

}  // namespace rubble::tools
