#include "protocol/fault_reset.h"

#include <algorithm>

#include "protocol/cia402.h"

namespace rubble::stabilizer {

namespace {

constexpr Tick kPulse = 100'000;

}  // namespace

FaultReset::FaultReset(int most, Tick first_pause, Tick longest_pause)
    : most_(most),
      first_pause_(first_pause),
      longest_pause_(longest_pause),
      left_(most),
      pause_(first_pause) {}

std::uint16_t FaultReset::advance(Tick now) {
  if (!inFault()) {
    next_ = now + pause_;
  }
  if (now < next_ || isGivenUp()) {
    return control::kDisableVoltage;
  }
  if (!pulsing_) {
    pulsing_ = true;
    --left_;
    ++count_;
    pause_ = std::min(2 * pause_, longest_pause_);
  }
  if (now < next_ + kPulse) {
    return control::kFaultReset;
  }
  pulsing_ = false;
  next_ = now + pause_;
  return control::kDisableVoltage;
}

bool FaultReset::end() {
  const bool was = inFault();
  next_ = 0;
  pulsing_ = false;
  return was;
}

void FaultReset::forget() {
  left_ = most_;
  pause_ = first_pause_;
}

}  // namespace rubble::stabilizer
