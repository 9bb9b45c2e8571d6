#include "protocol/bus_error.h"

#include <linux/can/error.h>

namespace rubble::stabilizer {

BusError busErrorOf(const CanFrame& error_frame) {
  if ((error_frame.id & CAN_ERR_BUSOFF) != 0) {
    return BusError::kBusOff;
  }
  if ((error_frame.id & CAN_ERR_ACK) != 0) {
    return BusError::kNoAcknowledge;
  }
  if ((error_frame.id & CAN_ERR_CRTL) != 0) {
    const std::uint8_t status = error_frame.data[1];
    if ((status & (CAN_ERR_CRTL_RX_OVERFLOW | CAN_ERR_CRTL_TX_OVERFLOW)) != 0) {
      return BusError::kOverflow;
    }
    if ((status & (CAN_ERR_CRTL_RX_WARNING | CAN_ERR_CRTL_TX_WARNING | CAN_ERR_CRTL_RX_PASSIVE |
                   CAN_ERR_CRTL_TX_PASSIVE)) != 0) {
      return BusError::kWarning;
    }
  }
  return BusError::kNone;
}

const char* describe(BusError error) {
  switch (error) {
    case BusError::kNone:
      return "";
    case BusError::kNoAcknowledge:
      return "nobody on the bus acknowledges; check that the drives are on, the cable and the bit rate";
    case BusError::kWarning:
      return "the bus has many errors; check its termination, cable and bit rate";
    case BusError::kOverflow:
      return "the CAN controller lost frames; lower the load of this host or of the bus";
    case BusError::kBusOff:
      return "is bus-off; check termination, cable and bit rate; it restarts by itself when it was set up "
             "with "
             "restart-ms 100";
  }
  return "";
}

}  // namespace rubble::stabilizer
