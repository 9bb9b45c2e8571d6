#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/time.h"

namespace rubble::lidar {

/// Maps the sensor's clock (24 bits of milliseconds, wrapping every 4.66 h; SCIP 2.0 sections 8.1 and 8.6) to
/// the host's.
///
/// A scan's arrival is its stamp plus the offset of the clocks plus a delay that only ever adds. So the
/// offset follows the lower envelope of arrival minus stamp: the supporting line below the last minute's
/// minima per second, whose slope is the drift of the sensor's quartz. The smallest delay, which the envelope
/// still holds, is measured once against TM's exchanges, where the sensor answers them, else taken as the
/// sweep's time. The offset in use moves by at most 1 ms/s, so transport never shows as jitter.
class DeviceClock {
 public:
  static constexpr std::int64_t kWrapMs = std::int64_t{1} << 24;

  struct Stamp {
    /// Of the scan's stamp; larger than the one before unless the host's clock was set back.
    common::Utime utime = 0;
    /// Since the stamp before, by the sensor's clock; 0 for the first one and after a jump.
    std::int64_t elapsed_ms = 0;
    /// The sensor's clock or the host's has jumped: the mapping has begun anew.
    bool jumped = false;
  };

  /// `least_delay`: microseconds from a stamp to the arrival of its scan, if the link took no time.
  explicit DeviceClock(common::Utime least_delay);

  /// One TM1 exchange, before the first scan: the clock was read somewhere between both host times.
  void synchronise(std::uint32_t device_ms, common::Utime sent, common::Utime received);

  /// A scan that was complete at `arrival` (host time).
  Stamp observe(std::uint32_t device_ms, common::Utime arrival);

  /// Host microseconds a device second drifts; 0 until 10 s have been seen.
  double driftPpm() const { return slope_ * 1e6; }

 private:
  struct Difference {
    std::int64_t device_us = 0;
    std::int64_t value = 0;  // Host minus device, microseconds.
  };

  std::int64_t unwrapped(std::uint32_t device_ms, common::Utime arrival) const;
  bool hasJumped(const Difference& difference) const;
  void begin(const Difference& difference);
  void follow(const Difference& difference);
  void closeSecond(const Difference& next);
  void fitEnvelope();
  double hullSlope() const;
  double envelopeAt(std::int64_t device_us) const;

  // From TM: host minus device lies between both.
  std::optional<std::int64_t> tm_low_;
  std::int64_t tm_high_ = 0;

  bool started_ = false;
  std::int64_t device_us_ = 0;  // Of the latest scan, unwrapped; and its arrival and stamp on the host.
  common::Utime arrival_ = 0;
  common::Utime utime_ = 0;

  // The stamp on the host is device time + offset_ - delay_.
  double offset_ = 0.0;
  std::int64_t delay_;
  std::int64_t settled_us_ = 0;  // Device time up to which the mapping is young.

  std::vector<Difference> minima_;  // Of the last minute's seconds.
  Difference current_;              // The smallest of this second, which began at:
  std::int64_t second_begin_us_ = 0;
  int late_seconds_ = 0;
  Difference anchor_;  // A point of the envelope.
  double slope_ = 0.0;
};

}  // namespace rubble::lidar
