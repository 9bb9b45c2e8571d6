#pragma once

#include <cstdint>
#include <string>

#include "protocol/cia402.h"
#include "protocol/sdo.h"

namespace rubble::stabilizer {

/// Why a drive does not work.
struct Problem {
  enum class Kind {
    kNone,
    kNoAnswer,      // No boot-up after a reset.
    kSdoTimeout,    // `entry` was not answered.
    kSdoAbort,      // `entry` was refused: abort code `code`.
    kNoDrive,       // Device type `code` is not CiA 402.
    kNoMode,        // It supports the modes `code` (0x6502) only.
    kNoStatus,      // Its TPDO does not come.
    kHeartbeat,     // Its heartbeat does not come.
    kRestarted,     // It has booted, or left operational, by itself.
    kFault,         // `code` is its EMCY's, 0 while none has come.
    kFaultForGood,  // The same, and it was reset as often as it may be.
    kNotEnabled,    // It stays in `state`.
    kNotFollowing,  // Its position stays away from the set-point.
  };
  Kind kind = Kind::kNone;
  ObjectEntry entry = {};
  std::uint32_t code = 0;
  DriveState state = DriveState::kNotReady;
};

/// With what to do, e.g. `sends no heartbeat; check its power and cable`.
std::string describe(const Problem& problem);

}  // namespace rubble::stabilizer
