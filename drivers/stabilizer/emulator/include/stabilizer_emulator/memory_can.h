#pragma once

#include <memory>

#include "device/can_port.h"

namespace rubble::stabilizer {

/// A CAN bus in memory: what one port writes all others read. It can be down, like an interface, and carry
/// error frames. Thread-safe; a port that nobody reads loses its newest frames.
class MemoryCan {
 public:
  MemoryCan();
  ~MemoryCan();

  /// Throws common::Error while it is down.
  std::unique_ptr<CanPort> open();

  /// All ports fail, as when an interface goes down.
  void takeDown();
  void bringUp();

  /// As if another node had sent it; error frames, too.
  void inject(const CanFrame& frame);

 private:
  class Port;
  struct Bus;
  std::shared_ptr<Bus> bus_;
};

}  // namespace rubble::stabilizer
