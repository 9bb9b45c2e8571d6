#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "common/file_descriptor.h"
#include "device/can_port.h"
#include "protocol/drive_pair.h"

namespace rubble::stabilizer {

/// Runs the pair of drives from a thread of its own, a cycle at every tick of a timer. When the port fails it
/// is opened again after a pause that doubles from try to try.
class StabilizerDriver {
 public:
  using Clock = std::chrono::steady_clock;

  struct Options {
    DrivePair::Options pair;
    std::chrono::milliseconds cycle{10};
    Clock::duration first_pause{};
    Clock::duration longest_pause{};
  };

  struct Status {
    PairStatus pair;
    bool open = false;
    /// What last happened to the port; empty when nothing did, or 10 s after it was opened again.
    std::string port_problem;
    std::int64_t port_failures = 0;
    std::int64_t cycles_missed = 0;
    std::int64_t frames_unsent = 0;     // The interface had no room.
    std::int64_t readings_dropped = 0;  // Nobody took them in time.
  };

  /// `wake` is called on the driver's thread when a reading waits.
  StabilizerDriver(const Options& options, OpenCanPort open, std::function<void()> wake);
  /// Stops the plate and the thread.
  ~StabilizerDriver();
  StabilizerDriver(const StabilizerDriver&) = delete;
  StabilizerDriver& operator=(const StabilizerDriver&) = delete;

  /// Replaces one that was not looked at yet.
  void command(const PlateCommand& command);
  /// The oldest one that waits.
  std::optional<PlateReading> takeReading();
  Status status() const;

 private:
  void run();
  void converse();
  void runCycle(CanPort& port);
  void readFrames(CanPort& port);
  /// Waits for the timer or the port (nullptr: none). False when the driver shall stop.
  bool wait(const CanPort* port, std::chrono::milliseconds timeout) const;
  void startTimer();
  std::int64_t takeTicks();
  void push(const PlateReading& reading);
  void fail(const std::string& what);

  static constexpr std::size_t kCapacity = 32;  // 0.3 s

  const Options options_;
  const OpenCanPort open_;
  const std::function<void()> wake_;
  const common::FileDescriptor stop_;   // An eventfd.
  const common::FileDescriptor timer_;  // A timerfd.
  DrivePair pair_;
  Clock::duration pause_;

  mutable std::mutex mutex_;
  Status status_;
  Clock::time_point failed_at_;
  std::optional<PlateCommand> command_;
  std::array<PlateReading, kCapacity> readings_;
  std::size_t oldest_ = 0;
  std::size_t waiting_ = 0;

  std::thread thread_;
};

}  // namespace rubble::stabilizer
