#pragma once

#include <cstdint>
#include <span>

#include "common/time.h"

namespace rubble::camera {

/// The host's clocks read one right after the other, ns.
struct ClockReading {
  std::int64_t monotonic_before = 0;
  std::int64_t epoch = 0;
  std::int64_t monotonic_after = 0;
};

/// Epoch minus monotonic time, ns, of the reading that took the shortest: a thread may lose the CPU amid one.
std::int64_t clockOffset(std::span<const ClockReading> readings);

/// When a buffer was filled, as its driver tells.
struct BufferStamp {
  /// ns of the monotonic clock.
  std::int64_t monotonic = 0;
  /// The stamp is the exposure's start; else its end.
  bool at_start = false;
};

/// Middle of the exposure. `exposure` (0 when unknown: then its start or end stands for it) and `delay` (from
/// start or end to the stamp) in s, `offset` as of clockOffset().
common::Utime midExposure(const BufferStamp& stamp, double exposure, double delay, std::int64_t offset);

/// Whether a stamp is of the monotonic clock, as V4L2's should be: it is less than 1 s from now (ns), which
/// no other clock's is. A little in the future is possible, where a driver knows when the exposure will have
/// ended.
bool isPlausible(std::int64_t monotonic_stamp, std::int64_t monotonic_now);

}  // namespace rubble::camera
