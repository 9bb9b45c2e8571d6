#pragma once

#include <cstdint>
#include <vector>

#include "emulated_motor.h"
#include "object_dictionary.h"
#include "protocol/canopen.h"
#include "stabilizer_emulator/stabilizer_emulator.h"

namespace rubble::stabilizer {

/// One CiA 402 drive: NMT and heartbeat, SDO, PDOs at SYNC, EMCY, the state machine of CiA 402, csp and pp.
/// Frames and times in, frames out.
class EmulatedDrive {
 public:
  /// It boots at once.
  EmulatedDrive(int node, const EmulatedModel& model);

  /// Appends its answers.
  void receive(const CanFrame& frame, Tick now, std::vector<CanFrame>& answers);
  /// Appends what it sends by itself: boot-up, heartbeat.
  void advance(Tick now, std::vector<CanFrame>& frames);
  void inject(DriveFault fault, std::vector<CanFrame>& frames);

  /// When advance() has something to say.
  Tick nextEvent() const;
  /// Increments.
  double position() const { return motor_.position(); }

 private:
  enum class State { kSwitchOnDisabled, kReady, kSwitchedOn, kEnabled, kQuickStop, kFault };

  void onNmt(const CanFrame& frame);
  void onSync(Tick now, std::vector<CanFrame>& answers);
  void onControlword(std::vector<CanFrame>& answers);
  void resetCommunication();
  void move(Tick now);
  std::uint16_t statusword() const;
  void emergency(std::uint16_t code, std::vector<CanFrame>& frames) const;

  const int node_;
  ObjectDictionary objects_;
  EmulatedMotor motor_;
  State state_ = State::kSwitchOnDisabled;
  NmtState nmt_ = NmtState::kBootUp;
  Tick next_heartbeat_ = 0;
  double target_ = 0.0;
  std::uint16_t controlword_ = 0;
  bool acknowledged_ = false;
  // An RPDO that waits for SYNC.
  CanFrame set_point_;
  bool has_set_point_ = false;

  bool off_ = false;
  bool lasting_ = false;
  bool silent_ = false;
  bool stuck_ = false;
  bool wrong_sdo_ = false;
  bool abort_sdo_ = false;
};

}  // namespace rubble::stabilizer
