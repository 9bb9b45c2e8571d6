#include "protocol/drive.h"

#include <algorithm>
#include <cstdlib>

namespace rubble::stabilizer {

namespace {

constexpr Tick kBootTimeout = 2'000'000;
constexpr Tick kSdoTimeout = 200'000;
constexpr int kSdoTries = 3;
constexpr Tick kStatusTimeout = 300'000;
constexpr Tick kEnableTimeout = 2'000'000;
constexpr Tick kFollowTimeout = 500'000;
constexpr Tick kSettled = 10'000'000;

constexpr std::uint32_t kCia402Profile = 402;  // The low 16 bits of the device type.

}  // namespace

Drive::Drive(const DriveOptions& options)
    : options_(options),
      steps_(setupSteps(options.setup)),
      pause_(options.first_pause),
      fault_reset_(options.fault_resets, options.first_pause, options.longest_pause) {}

void Drive::restart(Tick now) {
  enter(Phase::kPause, now);
  pause_end_ = now;
}

void Drive::receive(const CanFrame& frame, Tick now) {
  const std::uint32_t function = frame.id - static_cast<std::uint32_t>(options_.setup.node);
  if (function == cob::kStatus) {
    if (const auto reading = readStatus(frame)) {
      return onStatus(*reading, now);
    }
  } else if (function == cob::kHeartbeat) {
    if (const auto state = readHeartbeat(frame)) {
      return onHeartbeat(*state, now);
    }
  } else if (function == cob::kSdoAnswer) {
    if (const auto answer = readSdoAnswer(frame)) {
      return onSdo(*answer, now);
    }
  } else if (function == cob::kEmergency) {
    if (const auto emergency = readEmergency(frame)) {
      return onEmergency(*emergency);
    }
  }
  ++status_.unexpected;
}

void Drive::onHeartbeat(NmtState state, Tick now) {
  heartbeat_time_ = now;
  const bool running = phase_ == Phase::kEnabling || phase_ == Phase::kEnabled;
  if (state == NmtState::kBootUp) {
    if (running || phase_ == Phase::kStarting) {
      report({.kind = Problem::Kind::kRestarted});
      ++status_.failures;
    }
    beginSetup(now);
  } else if (running && state != NmtState::kOperational) {
    lose({.kind = Problem::Kind::kRestarted}, now);
  }
}

void Drive::onEmergency(const Emergency& emergency) {
  ++status_.emergencies;
  emergency_ = emergency.code;
  const Problem::Kind kind = status_.problem.kind;
  if ((kind == Problem::Kind::kFault || kind == Problem::Kind::kFaultForGood) && !status_.solved &&
      emergency_ != 0) {
    status_.problem.code = emergency_;
  }
}

void Drive::onSdo(const SdoAnswer& answer, Tick now) {
  if (phase_ != Phase::kSetup || step_tries_ == 0 || answer.entry != steps_[step_].entry) {
    ++status_.unexpected;
    return;
  }
  if (answer.kind == SdoAnswer::Kind::kAborted) {
    return lose({.kind = Problem::Kind::kSdoAbort, .entry = answer.entry, .code = answer.value}, now);
  }
  const bool is_read = steps_[step_].bytes == 0;
  if (is_read != (answer.kind == SdoAnswer::Kind::kUploaded)) {
    ++status_.unexpected;
    return;
  }
  if (!is_read || checkIdentity(answer, now)) {
    ++step_;
    step_tries_ = 0;
  }
}

bool Drive::checkIdentity(const SdoAnswer& answer, Tick now) {
  if (answer.entry == kDeviceType && (answer.value & 0xFFFF) != kCia402Profile) {
    lose({.kind = Problem::Kind::kNoDrive, .code = answer.value}, now);
    return false;
  }
  const std::uint32_t wanted = 1U << (static_cast<unsigned>(options_.setup.mode) - 1);
  if (answer.entry == kSupportedModes && (answer.value & wanted) == 0) {
    lose({.kind = Problem::Kind::kNoMode, .code = answer.value}, now);
    return false;
  }
  return true;
}

void Drive::onStatus(const DriveReading& reading, Tick now) {
  if (phase_ < Phase::kStarting) {
    ++status_.unexpected;
    return;
  }
  reading_ = reading;
  reading_time_ = now;
  const DriveState state = stateOf(reading.statusword);
  if (phase_ == Phase::kStarting) {
    // Not enabled yet, whatever it says: the first target has to be where it is.
    enter(Phase::kEnabling, now);
  } else if (phase_ == Phase::kEnabling && state == DriveState::kOperationEnabled) {
    enter(Phase::kEnabled, now);
    followed_ = now;
    fault_reset_.end();
    pause_ = options_.first_pause;
    solve(now);
  } else if (phase_ == Phase::kEnabled && state != DriveState::kOperationEnabled) {
    enter(Phase::kEnabling, now);
  }
}

void Drive::cycle(Tick now, std::int32_t target, std::vector<CanFrame>& frames) {
  switch (phase_) {
    case Phase::kPause:
      if (now >= pause_end_) {
        frames.push_back(nmtFrame(NmtCommand::kResetCommunication, options_.setup.node));
        enter(Phase::kBooting, now);
      }
      break;
    case Phase::kBooting:
      if (now - phase_begin_ > kBootTimeout) {
        lose({.kind = Problem::Kind::kNoAnswer}, now);
      }
      break;
    case Phase::kSetup:
      proceedSetup(now, frames);
      break;
    case Phase::kStarting:
      if (now - phase_begin_ > kStatusTimeout) {
        lose({.kind = Problem::Kind::kNoStatus}, now);
      }
      break;
    case Phase::kEnabling:
    case Phase::kEnabled: {
      const std::int32_t reachable = enabled() ? target : reading_->position;
      frames.push_back(setPointFrame(options_.setup.node, controlword(now), reachable));
      watch(now, reachable);
      break;
    }
  }
  if (status_.solved && now - solved_at_ > kSettled) {
    status_.problem = {};
    status_.solved = false;
  }
}

void Drive::stop(std::vector<CanFrame>& frames) const {
  if (reading_) {
    frames.push_back(setPointFrame(options_.setup.node, control::kQuickStop, reading_->position));
  }
}

void Drive::proceedSetup(Tick now, std::vector<CanFrame>& frames) {
  if (step_ == steps_.size()) {
    frames.push_back(nmtFrame(NmtCommand::kStart, options_.setup.node));
    enter(Phase::kStarting, now);
    return;
  }
  if (step_tries_ > 0 && now - step_sent_ < kSdoTimeout) {
    return;
  }
  const SetupStep& step = steps_[step_];
  if (step_tries_ == kSdoTries) {
    return lose({.kind = Problem::Kind::kSdoTimeout, .entry = step.entry}, now);
  }
  frames.push_back(step.bytes == 0
                       ? sdoUploadFrame(options_.setup.node, step.entry)
                       : sdoDownloadFrame(options_.setup.node, step.entry, step.value, step.bytes));
  ++step_tries_;
  step_sent_ = now;
}

void Drive::watch(Tick now, std::int32_t target) {
  if (now - heartbeat_time_ > options_.heartbeat_timeout) {
    return lose({.kind = Problem::Kind::kHeartbeat}, now);
  }
  if (now - reading_time_ > kStatusTimeout) {
    return lose({.kind = Problem::Kind::kNoStatus}, now);
  }
  if (!enabled()) {
    if (now - phase_begin_ > kEnableTimeout && !fault_reset_.inFault()) {
      report({.kind = Problem::Kind::kNotEnabled, .state = stateOf(reading_->statusword)});
    }
    return;
  }
  if (now - phase_begin_ > kSettled) {
    fault_reset_.forget();
  }
  if (std::llabs(std::int64_t{target} - reading_->position) <= options_.following_error) {
    followed_ = now;
    solve(now);
  } else if (now - followed_ > kFollowTimeout) {
    report({.kind = Problem::Kind::kNotFollowing});
  }
}

std::uint16_t Drive::controlword(Tick now) {
  const DriveState state = stateOf(reading_->statusword);
  if (state == DriveState::kFault) {
    if (!fault_reset_.inFault()) {
      report({.kind = Problem::Kind::kFault, .code = emergency_});
    }
    const std::uint16_t word = fault_reset_.advance(now);
    status_.fault_resets = fault_reset_.count();
    if (fault_reset_.isGivenUp()) {
      status_.problem.kind = Problem::Kind::kFaultForGood;
    }
    return word;
  }
  if (state != DriveState::kFaultReaction && fault_reset_.end()) {
    // The time to enable begins anew.
    phase_begin_ = now;
  }
  std::uint16_t word = commandTowardsEnabled(state);
  if (enabled() && options_.setup.mode == Mode::kProfilePosition) {
    word |= control::kChangeImmediately;
    word |= (reading_->statusword & kSetPointAcknowledged) != 0 ? std::uint16_t{0} : control::kNewSetPoint;
  }
  return word;
}

void Drive::enter(Phase phase, Tick now) {
  phase_ = phase;
  phase_begin_ = now;
  if (phase < Phase::kEnabling) {
    reading_.reset();
    fault_reset_.end();
  }
}

void Drive::beginSetup(Tick now) {
  enter(Phase::kSetup, now);
  step_ = 0;
  step_tries_ = 0;
  emergency_ = 0;
  fault_reset_.forget();
}

void Drive::lose(const Problem& problem, Tick now) {
  report(problem);
  ++status_.failures;
  enter(Phase::kPause, now);
  pause_end_ = now + pause_;
  pause_ = std::min(2 * pause_, options_.longest_pause);
}

void Drive::report(const Problem& problem) {
  status_.problem = problem;
  status_.solved = false;
}

void Drive::solve(Tick now) {
  if (status_.problem.kind != Problem::Kind::kNone && !status_.solved) {
    status_.solved = true;
    solved_at_ = now;
  }
}

}  // namespace rubble::stabilizer
