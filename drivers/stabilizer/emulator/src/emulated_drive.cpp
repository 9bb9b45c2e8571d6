#include "emulated_drive.h"

#include <cmath>
#include <limits>

#include "protocol/cia402.h"

namespace rubble::stabilizer {

namespace {

constexpr std::uint16_t kRpdo = 0x1400;
constexpr std::uint16_t kTpdo = 0x1800;
constexpr ObjectEntry kStatusword{0x6041, 0};
constexpr ObjectEntry kPosition{0x6064, 0};
constexpr ObjectEntry kTarget{0x607A, 0};

}  // namespace

EmulatedDrive::EmulatedDrive(int node, const EmulatedModel& model)
    : node_(node),
      motor_(model.speed * model.increments_per_rad, model.acceleration * model.increments_per_rad) {}

void EmulatedDrive::receive(const CanFrame& frame, Tick now, std::vector<CanFrame>& answers) {
  if (off_ || frame.is_error) {
    return;
  }
  if (frame.id == cob::kNmt) {
    onNmt(frame);
  } else if (frame.id == cob::kSync) {
    onSync(now, answers);
  } else if (frame.id == cob::kSdoRequest + static_cast<std::uint32_t>(node_) && frame.size == 8 &&
             nmt_ != NmtState::kStopped && nmt_ != NmtState::kBootUp) {
    CanFrame answer = objects_.serve(frame, node_);
    if (abort_sdo_ && answer.data[0] == 0x60) {
      abort_sdo_ = false;
      answer.data = {0x80, answer.data[1], answer.data[2], answer.data[3], 0x30, 0x00, 0x09, 0x06};
    }
    answer.data[1] ^= wrong_sdo_ ? 1 : 0;
    wrong_sdo_ = false;
    answers.push_back(answer);
  } else if (nmt_ == NmtState::kOperational && objects_.isPdoOn(kRpdo) && frame.id == objects_.cobId(kRpdo)) {
    set_point_ = frame;
    has_set_point_ = true;
  }
}

void EmulatedDrive::onNmt(const CanFrame& frame) {
  if (frame.size != 2 || (frame.data[1] != 0 && frame.data[1] != node_)) {
    return;
  }
  switch (static_cast<NmtCommand>(frame.data[0])) {
    case NmtCommand::kStart:
      nmt_ = NmtState::kOperational;
      break;
    case NmtCommand::kStop:
      nmt_ = NmtState::kStopped;
      break;
    case NmtCommand::kEnterPreOperational:
      nmt_ = NmtState::kPreOperational;
      break;
    case NmtCommand::kResetNode:
      state_ = State::kSwitchOnDisabled;
      resetCommunication();
      break;
    case NmtCommand::kResetCommunication:
      resetCommunication();
      break;
  }
}

void EmulatedDrive::resetCommunication() {
  objects_.reset();
  nmt_ = NmtState::kBootUp;
  silent_ = false;
  has_set_point_ = false;
}

void EmulatedDrive::advance(Tick now, std::vector<CanFrame>& frames) {
  move(now);
  if (off_) {
    return;
  }
  const auto say = [&](NmtState state) {
    frames.push_back({.id = cob::kHeartbeat + static_cast<std::uint32_t>(node_),
                      .data = {static_cast<std::uint8_t>(state)},
                      .size = 1});
  };
  const Tick interval = Tick{1000} * objects_.get16(0x1017);
  if (nmt_ == NmtState::kBootUp) {
    say(nmt_);
    nmt_ = NmtState::kPreOperational;
    next_heartbeat_ = now;
  } else if (interval > 0 && now >= next_heartbeat_) {
    if (!silent_) {
      say(nmt_);
    }
    next_heartbeat_ = now + interval;
  }
}

Tick EmulatedDrive::nextEvent() const {
  if (!off_ && nmt_ == NmtState::kBootUp) {
    return 0;
  }
  return off_ || objects_.get16(0x1017) == 0 ? std::numeric_limits<Tick>::max() : next_heartbeat_;
}

void EmulatedDrive::onSync(Tick now, std::vector<CanFrame>& answers) {
  move(now);
  if (nmt_ != NmtState::kOperational) {
    return;
  }
  if (has_set_point_) {
    has_set_point_ = false;
    if (objects_.unpackPdo(kRpdo, set_point_)) {
      onControlword(answers);
    } else {
      emergency(0x8210, answers);
    }
  }
  objects_.set(kStatusword, statusword());
  objects_.set(kPosition,
               static_cast<std::uint32_t>(static_cast<std::int32_t>(std::lround(motor_.position()))));
  if (objects_.isPdoOn(kTpdo)) {
    answers.push_back(objects_.packPdo(kTpdo));
  }
}

void EmulatedDrive::onControlword(std::vector<CanFrame>& answers) {
  const std::uint16_t word = objects_.get16(0x6040);
  const std::uint16_t rising = word & ~controlword_;
  controlword_ = word;
  const auto has = [word](std::uint16_t bits) { return (word & bits) == bits; };
  if (state_ == State::kFault) {
    if ((rising & control::kFaultReset) != 0 && !lasting_) {
      state_ = State::kSwitchOnDisabled;
      emergency(0, answers);
    }
  } else if (!has(control::kQuickStop)) {  // Bit 1 is 0: disable voltage.
    state_ = State::kSwitchOnDisabled;
  } else if (!has(0x0004)) {  // Quick stop.
    state_ = state_ == State::kEnabled || state_ == State::kQuickStop ? State::kQuickStop
                                                                      : State::kSwitchOnDisabled;
    target_ = motor_.position();
  } else if (!has(control::kSwitchOn)) {
    state_ = state_ == State::kQuickStop ? state_ : State::kReady;
  } else if (!has(control::kEnableOperation)) {
    state_ = state_ == State::kReady || state_ == State::kEnabled ? State::kSwitchedOn : state_;
  } else if (state_ == State::kReady) {
    state_ = State::kSwitchedOn;
  } else if (state_ == State::kSwitchedOn || state_ == State::kQuickStop) {
    state_ = State::kEnabled;
    target_ = motor_.position();
  }
  if (state_ == State::kEnabled) {
    if (objects_.get({0x6060, 0}) == static_cast<std::uint32_t>(Mode::kCyclicSynchronousPosition)) {
      target_ = objects_.get32(kTarget.index);
    } else if ((rising & control::kNewSetPoint) != 0 && !acknowledged_) {
      target_ = objects_.get32(kTarget.index);
      acknowledged_ = true;
    }
  }
  acknowledged_ = acknowledged_ && has(control::kNewSetPoint);
}

void EmulatedDrive::move(Tick now) {
  const bool powered = state_ == State::kEnabled || state_ == State::kQuickStop;
  if (powered && !stuck_ && !off_) {
    motor_.advance(now, target_);
  } else {
    motor_.brake(now);
  }
}

std::uint16_t EmulatedDrive::statusword() const {
  constexpr std::uint16_t kRemoteAndVoltage = 0x0210;
  std::uint16_t word = kRemoteAndVoltage;
  switch (state_) {
    case State::kSwitchOnDisabled:
      return word | 0x40;
    case State::kReady:
      return word | 0x21;
    case State::kSwitchedOn:
      return word | 0x23;
    case State::kEnabled: {
      // Bit 12: pp: the set-point was taken; csp: the drive follows.
      const bool follows =
          objects_.get({0x6060, 0}) == static_cast<std::uint32_t>(Mode::kCyclicSynchronousPosition);
      return word | 0x27 | (follows || acknowledged_ ? kSetPointAcknowledged : std::uint16_t{0});
    }
    case State::kQuickStop:
      return word | 0x07;
    case State::kFault:
      return word | 0x08;
  }
  return word;
}

void EmulatedDrive::emergency(std::uint16_t code, std::vector<CanFrame>& frames) const {
  CanFrame frame{.id = cob::kEmergency + static_cast<std::uint32_t>(node_), .size = 8};
  writeLittleEndian(code, std::span(frame.data).first(2));
  frame.data[2] = code == 0 ? 0 : 1;
  frames.push_back(frame);
}

void EmulatedDrive::inject(DriveFault fault, std::vector<CanFrame>& frames) {
  switch (fault) {
    case DriveFault::kFault:
    case DriveFault::kLastingFault:
      state_ = State::kFault;
      lasting_ = fault == DriveFault::kLastingFault;
      emergency(0x8611, frames);
      break;
    case DriveFault::kSilence:
      silent_ = true;
      break;
    case DriveFault::kStuck:
      stuck_ = true;
      break;
    case DriveFault::kFree:
      stuck_ = false;
      break;
    case DriveFault::kWrongSdo:
    case DriveFault::kSdoAbort:
      // Shows at the next set-up.
      wrong_sdo_ = fault == DriveFault::kWrongSdo;
      abort_sdo_ = fault == DriveFault::kSdoAbort;
      resetCommunication();
      break;
    case DriveFault::kOff:
      off_ = true;
      break;
    case DriveFault::kOn:
      off_ = false;
      lasting_ = false;
      state_ = State::kSwitchOnDisabled;
      resetCommunication();
      break;
  }
}

}  // namespace rubble::stabilizer
