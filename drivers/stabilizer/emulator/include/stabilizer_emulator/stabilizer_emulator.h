#pragma once

#include <array>
#include <memory>
#include <string_view>

#include "device/can_port.h"

namespace rubble::stabilizer {

/// What goes wrong with a drive.
enum class DriveFault {
  kFault,         // Fault with EMCY 0x8611, until it is reset.
  kLastingFault,  // The same, until it was off.
  kSilence,       // No heartbeat until its communication is reset.
  kStuck,         // The axis is blocked
  kFree,          // until this.
  kWrongSdo,      // It restarts, and answers the first SDO with another index.
  kSdoAbort,      // It restarts, and refuses the first value that it is given.
  kOff,           // No power
  kOn,            // until this.
};

/// `fault`, `lasting-fault`, `silence`, `stuck`, `free`, `wrong-sdo`, `sdo-abort`, `off`, `on`. Throws
/// common::Error naming them for anything else.
DriveFault parseDriveFault(std::string_view name);

/// The servos that are emulated.
struct EmulatedModel {
  std::array<int, 2> nodes{1, 2};  // Roll, pitch.
  double increments_per_rad = 4096 * 50.0 / 6.283185307179586;
  double speed = 2.5;          // rad/s
  double acceleration = 50.0;  // rad/s^2
};

/// Both drives of the stabiliser on a CAN bus, from a thread of its own.
class StabilizerEmulator {
 public:
  StabilizerEmulator(const EmulatedModel& model, std::unique_ptr<CanPort> port);
  ~StabilizerEmulator();
  StabilizerEmulator(const StabilizerEmulator&) = delete;
  StabilizerEmulator& operator=(const StabilizerEmulator&) = delete;

  /// `axis`: 0 roll, 1 pitch.
  void inject(std::size_t axis, DriveFault fault);

  /// Throws what has ended the drives: the port's common::Error.
  void check() const;

  /// True angle of the axis, rad.
  double angle(std::size_t axis) const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace rubble::stabilizer
