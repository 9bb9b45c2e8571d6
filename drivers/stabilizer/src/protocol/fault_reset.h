#pragma once

#include <cstdint>

#include "protocol/tick.h"

namespace rubble::stabilizer {

/// Leads a drive out of its fault (CiA 402 transition 15: a rising edge of the controlword's bit 7), after a
/// pause that doubles from try to try, and not more often than allowed.
class FaultReset {
 public:
  FaultReset(int most, Tick first_pause, Tick longest_pause);

  /// What the controlword shall be while the drive is in its fault.
  std::uint16_t advance(Tick now);
  /// The drive is in no fault any more. False when it was in none.
  bool end();
  /// All tries are free again.
  void forget();

  bool inFault() const { return next_ != 0; }
  /// No try is left, and the last one was in vain.
  bool isGivenUp() const { return inFault() && left_ == 0 && !pulsing_; }
  std::int64_t count() const { return count_; }

 private:
  const int most_;
  const Tick first_pause_;
  const Tick longest_pause_;
  int left_;
  Tick pause_;
  Tick next_ = 0;  // When the next try begins, or the one that is made began; 0: in no fault.
  bool pulsing_ = false;
  std::int64_t count_ = 0;
};

}  // namespace rubble::stabilizer
