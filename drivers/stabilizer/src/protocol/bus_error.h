#pragma once

#include "protocol/can_frame.h"

namespace rubble::stabilizer {

/// What an error frame of SocketCAN means for the driver (linux/can/error.h).
enum class BusError {
  kNone,           // Nothing to worry about, or better again.
  kNoAcknowledge,  // Nobody else is on the bus.
  kWarning,        // Many errors: error warning or error passive.
  kOverflow,       // The controller lost frames.
  kBusOff,         // The controller has given up.
};

BusError busErrorOf(const CanFrame& error_frame);
/// With what to do; "" for kNone.
const char* describe(BusError error);

}  // namespace rubble::stabilizer
