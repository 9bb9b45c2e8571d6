#pragma once

#include <string>

#include "lcm_io/bus.h"
#include "lcm_io/log_file.h"

namespace rubble::lcm_io {

/// A log as a bus, `file://LOG?speed=0`: read only and lossless, the log waits for the process and its time
/// is the bus's. LCM's own file provider stamps messages with the wall clock instead.
class LogBus : public Bus {
 public:
  static constexpr char kScheme[] = "file://";

  /// Throws Error for another URL and for what is no log.
  explicit LogBus(const std::string& url);

  /// Throws Error naming the byte where the log is damaged.
  bool dispatch(std::chrono::milliseconds timeout) override;
  bool ended() const override { return ended_; }
  common::Utime now() const override { return now_; }
  void stopReceiving() override { ended_ = true; }

 private:
  void attach(const std::string& /*channel*/) override {}
  bool send(const std::string& /*channel*/, ByteView /*data*/) override { return false; }

  LogReader log_;
  common::Utime now_ = 0;
  bool ended_ = false;
};

}  // namespace rubble::lcm_io
