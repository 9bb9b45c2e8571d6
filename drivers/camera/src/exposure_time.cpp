#include "exposure_time.h"

#include <algorithm>
#include <cstdlib>

#include "common/error.h"

namespace rubble::camera {

namespace {

constexpr std::int64_t kSecond = 1'000'000'000;

std::int64_t duration(const ClockReading& reading) {
  return reading.monotonic_after - reading.monotonic_before;
}

}  // namespace

std::int64_t clockOffset(std::span<const ClockReading> readings) {
  RUBBLE_CHECK(!readings.empty());
  const auto best = std::min_element(readings.begin(), readings.end(),
                                     [](const auto& a, const auto& b) { return duration(a) < duration(b); });
  return best->epoch - (best->monotonic_before + duration(*best) / 2);
}

common::Utime midExposure(const BufferStamp& stamp, double exposure, double delay, std::int64_t offset) {
  const double shift = (stamp.at_start ? 0.5 : -0.5) * exposure - delay;
  return (stamp.monotonic + offset + 500) / 1000 + common::utimeFromSeconds(shift);
}

bool isPlausible(std::int64_t monotonic_stamp, std::int64_t monotonic_now) {
  return std::abs(monotonic_now - monotonic_stamp) <= kSecond;
}

}  // namespace rubble::camera
