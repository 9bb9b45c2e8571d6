#pragma once

#include <cmath>
#include <cstdint>

namespace rubble::common {

/// Microseconds since the epoch: the only representation of time in messages and algorithms.
/// Pictures are stamped at mid-exposure, scans at their first beam.
using Utime = std::int64_t;

inline constexpr Utime kMicrosecondsPerSecond = 1'000'000;

/// Seconds to microseconds, rounded to nearest.
inline Utime utimeFromSeconds(double seconds) { return std::llround(seconds * 1e6); }

inline double secondsFromUtime(Utime utime) { return static_cast<double>(utime) * 1e-6; }

}  // namespace rubble::common
