#pragma once

#include <functional>
#include <memory>

#include "protocol/can_frame.h"

namespace rubble::stabilizer {

/// An open end of a CAN bus; nothing here waits. Failures are a common::Error that says what happened and
/// what to do, without the interface's name; the port is then of no more use.
class CanPort {
 public:
  virtual ~CanPort() = default;
  CanPort() = default;
  CanPort(const CanPort&) = delete;
  CanPort& operator=(const CanPort&) = delete;

  /// Can be read when a frame waits or the port has failed.
  virtual int fd() const = 0;
  /// False when no frame waits.
  virtual bool read(CanFrame& frame) = 0;
  /// False, and the frame is lost, when the interface has no room for it.
  virtual bool write(const CanFrame& frame) = 0;
};

/// Throws common::Error as the port does.
using OpenCanPort = std::function<std::unique_ptr<CanPort>()>;

}  // namespace rubble::stabilizer
