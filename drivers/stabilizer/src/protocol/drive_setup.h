#pragma once

#include <cstdint>
#include <vector>

#include "protocol/cia402.h"
#include "protocol/sdo.h"

namespace rubble::stabilizer {

/// How a drive is to work.
struct DriveSetup {
  int node = 1;
  Mode mode = Mode::kCyclicSynchronousPosition;
  int cycle_ms = 10;
  int heartbeat_ms = 100;
  // Of profile position; increments/s and increments/s^2.
  std::uint32_t profile_velocity = 0;
  std::uint32_t profile_acceleration = 0;
};

/// One SDO transfer.
struct SetupStep {
  ObjectEntry entry;
  std::uint32_t value = 0;
  /// Of the value; 0: it is read.
  int bytes = 0;
};

inline constexpr ObjectEntry kDeviceType{0x1000, 0};
inline constexpr ObjectEntry kSupportedModes{0x6502, 0};

/// All transfers from boot-up to ready for NMT start: who it is, its heartbeat, the PDOs (mapped as CiA 301
/// section 7.5.2.36 wants: switched off, emptied, filled, switched on), the mode of operation. Both PDOs work
/// at every SYNC.
std::vector<SetupStep> setupSteps(const DriveSetup& setup);

}  // namespace rubble::stabilizer
