#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "exposure_time.h"

namespace rubble::camera {

/// What the driver asks of the kernel. The real one is makeSystemCalls(); tests script another.
class SystemCalls {
 public:
  enum class Wait { kReady, kTimeout, kWoken };

  virtual ~SystemCalls() = default;

  /// A file descriptor for reading and writing that never blocks, or -errno.
  virtual int open(const std::string& path) = 0;
  virtual void close(int fd) = 0;
  /// ioctl(2), repeated when a signal comes between; >= 0 or -errno.
  virtual int control(int fd, unsigned long request, void* argument) = 0;
  /// Shared memory of the device; null on failure.
  virtual void* map(int fd, std::size_t size, std::int64_t offset) = 0;
  virtual void unmap(void* memory, std::size_t size) = 0;
  /// Until the device has a buffer or a fault; without a device (fd -1) until the time is over.
  virtual Wait wait(int fd, std::chrono::milliseconds timeout) = 0;
  /// Ends this and every later wait(). The only call that any thread may make.
  virtual void wake() = 0;
  virtual ClockReading readClocks() = 0;
};

/// Throws common::Error when the process has no file descriptor left.
std::unique_ptr<SystemCalls> makeSystemCalls();

}  // namespace rubble::camera
