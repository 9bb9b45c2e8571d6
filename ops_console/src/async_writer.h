#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "log_sink.h"

namespace rubble::ops_console {

/// Puts messages into a sink from a thread of its own: push() never waits for the disk. What the sink has not
/// taken waits in a queue bounded by bytes that drops its oldest. After an error the sink is tried again
/// every second, and nothing that still waits is lost.
class AsyncWriter {
 public:
  using Clock = std::chrono::steady_clock;

  struct Status {
    std::int64_t written = 0;
    std::int64_t written_bytes = 0;
    /// Never written: the queue was full, or the disk refused to the end.
    std::int64_t dropped = 0;
    std::size_t queued_bytes = 0;
    /// Why the sink does not take anything now; empty when it does.
    std::string error;
    /// How long the sink has been busy with one call.
    Clock::duration busy{};
  };

  AsyncWriter(std::unique_ptr<LogSink> sink, std::size_t queue_bytes);
  ~AsyncWriter();
  AsyncWriter(const AsyncWriter&) = delete;
  AsyncWriter& operator=(const AsyncWriter&) = delete;

  void push(lcm_io::RawMessage message);

  /// Writes and syncs what waits, then stops; waits for a slow disk, not for one that refuses.
  void finish();

  Status status() const;

 private:
  using Batch = std::vector<lcm_io::RawMessage>;

  void run();
  void dropOverflow();
  Batch takeBatch();
  void putBack(Batch batch);

  const std::unique_ptr<LogSink> sink_;
  const std::size_t capacity_bytes_;

  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<lcm_io::RawMessage> queue_;
  Status status_;
  std::optional<Clock::time_point> busy_since_;
  bool closed_ = false;
  std::thread thread_;
};

}  // namespace rubble::ops_console
