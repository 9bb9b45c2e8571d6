#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "device/address.h"
#include "device/connection.h"
#include "device/scan_queue.h"
#include "protocol/session.h"

namespace rubble::lidar {

/// Keeps a sensor scanning from a thread of its own: connects, talks, and when that ends for whatever reason
/// connects again after a pause that doubles from try to try.
class LidarReader {
 public:
  using Clock = std::chrono::steady_clock;

  struct Options {
    Address address;
    int baud = 115'200;
    ScanWish wish;
    /// Without an answer, or a scan, for that long the sensor counts as hung.
    Clock::duration silence{};
    Clock::duration first_pause{};
    Clock::duration longest_pause{};
  };

  enum class State {
    kConnecting,  // Nothing has failed yet.
    kScanning,
    kVerifying,  // The sensor checks itself.
    kFailed,     // Until scans flow again.
  };

  struct Status {
    State state = State::kConnecting;
    /// When failed: what happened and what to do, naming the device.
    std::string problem;
    /// When scanning: what went wrong within the last 10 s; empty when nothing did.
    std::string warning;
    SessionCounters counters;  // Over all conversations.
    std::int64_t failures = 0;
    std::int64_t dropped = 0;  // Scans that nobody took in time.
  };

  /// `wake` is called on the reader's thread when a scan waits.
  LidarReader(Options options, std::function<void()> wake);
  /// Stops the scanning and the thread.
  ~LidarReader();
  LidarReader(const LidarReader&) = delete;
  LidarReader& operator=(const LidarReader&) = delete;

  /// The oldest scan that waits; false when none does.
  bool takeScan(LidarScan& scan) { return queue_.pop(scan); }

  Status status() const;

 private:
  void run();
  void converse();
  void talk(Connection& connection, Session& session);
  /// False when the reader shall stop.
  bool waitForBytes(int fd, Clock::time_point deadline) const;
  void onScan(LidarScan& scan);
  void note(const Session& session);
  void fail(const std::string& what);
  void announce(const Session& session);

  const Options options_;
  const std::function<void()> wake_;
  const FileDescriptor stop_;  // An eventfd.
  ScanQueue queue_;
  bool reset_next_ = false;
  Clock::duration pause_;
  SessionCounters before_;  // Of the conversations that have ended.
  std::string announced_;

  mutable std::mutex mutex_;
  Status status_;
  Clock::time_point warning_time_;

  std::thread thread_;
};

}  // namespace rubble::lidar
