#include "protocol/device_clock.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace rubble::lidar {

namespace {

constexpr std::int64_t kMillisecond = 1000;
constexpr std::int64_t kSecond = 1'000'000;
// Stamps are cut to whole milliseconds; on average that takes half of one off.
constexpr std::int64_t kHalfTick = 500;
constexpr std::size_t kWindowSeconds = 60;
constexpr std::int64_t kShortestFit = 10 * kSecond;
constexpr double kMaxDrift = 500e-6;  // Quartzes are within 100 ppm.
constexpr double kMaxSlew = 1e-3;
// While the mapping is this young, a smaller delay than ever before is taken over at once.
constexpr std::int64_t kSettling = 2 * kSecond;
// No delay can be this much smaller than the smallest; one that is this much larger for seconds on end is
// none.
constexpr double kJump = 50.0 * kMillisecond;
constexpr int kLateSeconds = 3;
// From a stamp to the arrival of its scan; more than that is no answer to TM.
constexpr std::int64_t kLongestDelay = kSecond;

}  // namespace

DeviceClock::DeviceClock(common::Utime least_delay) : delay_(least_delay) {
  minima_.reserve(kWindowSeconds + 1);
}

void DeviceClock::synchronise(std::uint32_t device_ms, common::Utime sent, common::Utime received) {
  // Read at a device time of device_ms to device_ms + 1, at a host time of sent to received.
  const std::int64_t low = sent - (static_cast<std::int64_t>(device_ms) + 1) * kMillisecond;
  const std::int64_t high = received - static_cast<std::int64_t>(device_ms) * kMillisecond;
  tm_high_ = tm_low_ ? std::min(tm_high_, high) : high;
  tm_low_ = std::max(tm_low_.value_or(low), low);
}

DeviceClock::Stamp DeviceClock::observe(std::uint32_t device_ms, common::Utime arrival) {
  const std::int64_t device_us = unwrapped(device_ms, arrival) * kMillisecond;
  const Difference difference{device_us, arrival - device_us};
  Stamp stamp;
  if (!started_) {
    begin(difference);
    // TM tells the offset until the envelope is known; the difference is the delay.
    if (tm_low_) {
      offset_ = static_cast<double>((*tm_low_ + tm_high_) / 2 + delay_);
    }
  } else if (hasJumped(difference)) {
    stamp.jumped = true;
    tm_low_.reset();
    begin(difference);
  } else {
    stamp.elapsed_ms = (device_us - device_us_) / kMillisecond;
    follow(difference);
  }
  stamp.utime = device_us + std::llround(offset_) - delay_ + kHalfTick;
  if (started_ && arrival >= arrival_) {
    stamp.utime = std::max(stamp.utime, utime_ + 1);
  }
  started_ = true;
  device_us_ = device_us;
  arrival_ = arrival;
  utime_ = stamp.utime;
  return stamp;
}

std::int64_t DeviceClock::unwrapped(std::uint32_t device_ms, common::Utime arrival) const {
  const std::int64_t raw = device_ms % kWrapMs;
  if (!started_) {
    return raw;
  }
  const std::int64_t expected = (device_us_ + arrival - arrival_) / kMillisecond;
  const double wraps = std::round(static_cast<double>(expected - raw) / static_cast<double>(kWrapMs));
  return raw + static_cast<std::int64_t>(wraps) * kWrapMs;
}

bool DeviceClock::hasJumped(const Difference& difference) const {
  // The first scans may have waited in this host.
  const double margin = difference.device_us < settled_us_ ? static_cast<double>(kSecond) : kJump;
  return difference.device_us <= device_us_ ||
         static_cast<double>(difference.value) < envelopeAt(difference.device_us) - margin ||
         late_seconds_ >= kLateSeconds;
}

void DeviceClock::begin(const Difference& difference) {
  minima_.clear();
  current_ = difference;
  anchor_ = difference;
  second_begin_us_ = difference.device_us;
  settled_us_ = difference.device_us + kSettling;
  late_seconds_ = 0;
  offset_ = static_cast<double>(difference.value);
}

void DeviceClock::follow(const Difference& difference) {
  if (difference.device_us - second_begin_us_ >= kSecond) {
    closeSecond(difference);
  } else if (difference.value < current_.value) {
    current_ = difference;
  }
  if (difference.device_us < settled_us_) {
    if (!tm_low_) {
      offset_ = std::min(offset_, static_cast<double>(difference.value));
    }
    return;
  }
  const double wanted = envelopeAt(difference.device_us);
  if (tm_low_) {
    const std::int64_t measured = delay_ + std::llround(wanted - offset_);
    if (measured >= 0 && measured < kLongestDelay) {
      delay_ = measured;
      offset_ = wanted;
    }
    tm_low_.reset();
  }
  const double slew = kMaxSlew * static_cast<double>(difference.device_us - device_us_);
  offset_ = std::clamp(wanted, offset_ - slew, offset_ + slew);
}

void DeviceClock::closeSecond(const Difference& next) {
  const bool late = static_cast<double>(current_.value) > envelopeAt(current_.device_us) + kJump;
  late_seconds_ = late ? late_seconds_ + 1 : 0;
  if (minima_.size() == kWindowSeconds) {
    minima_.erase(minima_.begin());
  }
  minima_.push_back(current_);
  fitEnvelope();
  current_ = next;
  second_begin_us_ = next.device_us;
}

void DeviceClock::fitEnvelope() {
  if (minima_.back().device_us - minima_.front().device_us >= kShortestFit) {
    slope_ = std::clamp(hullSlope(), -kMaxDrift, kMaxDrift);
  }
  const std::int64_t at = minima_.back().device_us;
  double lowest = static_cast<double>(minima_.back().value);
  for (const Difference& d : minima_) {
    lowest = std::min(lowest, static_cast<double>(d.value) + slope_ * static_cast<double>(at - d.device_us));
  }
  anchor_ = {at, std::llround(lowest)};
}

/// The slope of the lower hull's edge under the middle of the window: of all lines below the points it is the
/// nearest to them (Moon, Skelly, Towsley: Estimation and removal of clock skew, INFOCOM 1999).
double DeviceClock::hullSlope() const {
  const auto slope = [](const Difference& a, const Difference& b) {
    return static_cast<double>(b.value - a.value) / static_cast<double>(b.device_us - a.device_us);
  };
  std::array<Difference, kWindowSeconds> hull;
  std::size_t size = 0;
  double middle = 0.0;
  for (const Difference& d : minima_) {
    while (size >= 2 && slope(hull[size - 2], hull[size - 1]) >= slope(hull[size - 1], d)) {
      --size;
    }
    hull[size++] = d;
    middle += static_cast<double>(d.device_us) / static_cast<double>(minima_.size());
  }
  std::size_t right = 1;
  while (right + 1 < size && static_cast<double>(hull[right].device_us) < middle) {
    ++right;
  }
  return slope(hull[right - 1], hull[right]);
}

double DeviceClock::envelopeAt(std::int64_t device_us) const {
  return static_cast<double>(anchor_.value) + slope_ * static_cast<double>(device_us - anchor_.device_us);
}

}  // namespace rubble::lidar
