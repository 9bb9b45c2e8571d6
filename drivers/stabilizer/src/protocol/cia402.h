#pragma once

#include <cstdint>

namespace rubble::stabilizer {

/// States of a drive (CiA 402-2 section on the power drive system's finite state automaton).
enum class DriveState {
  kNotReady,
  kSwitchOnDisabled,
  kReadyToSwitchOn,
  kSwitchedOn,
  kOperationEnabled,
  kQuickStopActive,
  kFaultReaction,
  kFault,
};

/// Of the statusword 0x6041. A pattern that the standard does not have counts as kNotReady.
DriveState stateOf(std::uint16_t statusword);
const char* toString(DriveState state);

/// Bits of the controlword 0x6040.
namespace control {
inline constexpr std::uint16_t kDisableVoltage = 0x0000;
inline constexpr std::uint16_t kQuickStop = 0x0002;
inline constexpr std::uint16_t kShutdown = 0x0006;
inline constexpr std::uint16_t kSwitchOn = 0x0007;
inline constexpr std::uint16_t kEnableOperation = 0x000F;
inline constexpr std::uint16_t kNewSetPoint = 0x0010;        // Profile position, rising edge.
inline constexpr std::uint16_t kChangeImmediately = 0x0020;  // Profile position.
inline constexpr std::uint16_t kFaultReset = 0x0080;         // Rising edge.
}  // namespace control

/// Bit of the statusword: in profile position the new set-point was taken.
inline constexpr std::uint16_t kSetPointAcknowledged = 0x1000;

/// Modes of operation, 0x6060.
enum class Mode : std::uint8_t { kProfilePosition = 1, kCyclicSynchronousPosition = 8 };

/// The command that brings a drive one state nearer to kOperationEnabled, or keeps it there. In kFault it is
/// kDisableVoltage: only a rising kFaultReset leads out.
std::uint16_t commandTowardsEnabled(DriveState state);

}  // namespace rubble::stabilizer
