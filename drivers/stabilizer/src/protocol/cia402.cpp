#include "protocol/cia402.h"

namespace rubble::stabilizer {

DriveState stateOf(std::uint16_t statusword) {
  switch (statusword & 0x4F) {
    case 0x40:
      return DriveState::kSwitchOnDisabled;
    case 0x0F:
      return DriveState::kFaultReaction;
    case 0x08:
      return DriveState::kFault;
    default:
      break;
  }
  switch (statusword & 0x6F) {
    case 0x21:
      return DriveState::kReadyToSwitchOn;
    case 0x23:
      return DriveState::kSwitchedOn;
    case 0x27:
      return DriveState::kOperationEnabled;
    case 0x07:
      return DriveState::kQuickStopActive;
    default:
      return DriveState::kNotReady;
  }
}

const char* toString(DriveState state) {
  switch (state) {
    case DriveState::kNotReady:
      return "not ready to switch on";
    case DriveState::kSwitchOnDisabled:
      return "switch on disabled";
    case DriveState::kReadyToSwitchOn:
      return "ready to switch on";
    case DriveState::kSwitchedOn:
      return "switched on";
    case DriveState::kOperationEnabled:
      return "operation enabled";
    case DriveState::kQuickStopActive:
      return "quick stop active";
    case DriveState::kFaultReaction:
      return "fault reaction active";
    case DriveState::kFault:
      return "fault";
  }
  return "";
}

std::uint16_t commandTowardsEnabled(DriveState state) {
  switch (state) {
    case DriveState::kSwitchOnDisabled:
      return control::kShutdown;
    case DriveState::kReadyToSwitchOn:
      return control::kSwitchOn;
    case DriveState::kSwitchedOn:
    case DriveState::kOperationEnabled:
      return control::kEnableOperation;
    case DriveState::kQuickStopActive:  // Transition 12, to switch on disabled.
    case DriveState::kNotReady:
    case DriveState::kFaultReaction:
    case DriveState::kFault:
      break;
  }
  return control::kDisableVoltage;
}

}  // namespace rubble::stabilizer
