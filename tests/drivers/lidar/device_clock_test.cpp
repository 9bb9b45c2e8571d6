#include "protocol/device_clock.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace rubble::lidar {
namespace {

constexpr common::Utime kEpoch = 1'700'000'000'000'000;
constexpr common::Utime kScan = 25'137;  // A motor never turns at exactly 40 Hz.
constexpr common::Utime kSweep = 18'750;
constexpr common::Utime kLink = 400;
constexpr common::Utime kSecond = 1'000'000;

/// A sensor whose clock is `drift` too slow, behind a link that is never faster than kLink.
struct Simulation {
  double drift = 0.0;
  std::int64_t clock_begin_us = 123'456'789;
  std::mt19937 random{7};
  DeviceClock clock{kSweep};
  common::Utime host = kEpoch;  // Of the scan's stamp.

  std::uint32_t deviceMs(common::Utime at) const {
    const double elapsed = static_cast<double>(at - kEpoch) / (1.0 + drift);
    return static_cast<std::uint32_t>((clock_begin_us + std::llround(elapsed)) / 1000 % DeviceClock::kWrapMs);
  }

  void synchronise() {
    for (int i = 0; i < 10; ++i) {
      const common::Utime sent = host;
      host += 300 + random() % 800;
      const common::Utime read = sent + 150;
      clock.synchronise(deviceMs(read), sent, host);
      host += 37;
    }
  }

  common::Utime delay() {
    std::exponential_distribution<double> jitter(1.0 / 700.0);
    const common::Utime stall = random() % 100 == 0 ? 30'000 : 0;
    return kSweep + kLink + std::llround(jitter(random)) + stall;
  }

  DeviceClock::Stamp scan() {
    host += kScan;
    return clock.observe(deviceMs(host), host + delay());
  }

  /// Microseconds by which the stamp is off.
  double error(const DeviceClock::Stamp& stamp) const { return static_cast<double>(stamp.utime - host); }
};

class DeviceClockTest : public testing::TestWithParam<double> {};

TEST_P(DeviceClockTest, WithTimeSynchronisationEveryStampIsWithinAMillisecondAndAHalf) {
  Simulation sensor{.drift = GetParam()};
  sensor.synchronise();
  double worst = 0.0;
  for (int i = 0; i < 5 * 60 * 40; ++i) {
    const DeviceClock::Stamp stamp = sensor.scan();
    ASSERT_FALSE(stamp.jumped) << i;
    worst = std::max(worst, std::abs(sensor.error(stamp)));
  }
  EXPECT_LT(worst, 1500.0);
  EXPECT_NEAR(sensor.clock.driftPpm(), 1e6 * GetParam(), 15.0);
}

TEST_P(DeviceClockTest, WithoutItTheLinksOwnTimeIsTheError) {
  Simulation sensor{.drift = GetParam()};
  double worst = 0.0;
  for (int i = 0; i < 5 * 60 * 40; ++i) {
    const DeviceClock::Stamp stamp = sensor.scan();
    ASSERT_FALSE(stamp.jumped) << i;
    if (i > 10 * 40) {
      worst = std::max(worst, std::abs(sensor.error(stamp) - kLink));
    }
  }
  EXPECT_LT(worst, 1500.0);
}

INSTANTIATE_TEST_SUITE_P(Drifts, DeviceClockTest, testing::Values(0.0, 80e-6, -80e-6));

TEST(DeviceClock, IntervalsDoNotShowTheTransport) {
  Simulation sensor{.drift = 30e-6};
  sensor.synchronise();
  common::Utime last = sensor.scan().utime;
  for (int i = 0; i < 2000; ++i) {
    const DeviceClock::Stamp stamp = sensor.scan();
    // Two cuts to milliseconds, and 1 ms/s.
    EXPECT_NEAR(static_cast<double>(stamp.utime - last), kScan, 1000.0 + 50.0);
    last = stamp.utime;
  }
}

TEST(DeviceClock, TheWrapAfterFourHoursIsNoJump) {
  Simulation sensor;
  sensor.clock_begin_us = (DeviceClock::kWrapMs - 10'000) * 1000;
  sensor.synchronise();
  common::Utime last = 0;
  bool wrapped = false;
  for (int i = 0; i < 20 * 40; ++i) {
    const std::uint32_t before = sensor.deviceMs(sensor.host);
    const DeviceClock::Stamp stamp = sensor.scan();
    wrapped |= sensor.deviceMs(sensor.host) < before;
    EXPECT_FALSE(stamp.jumped);
    EXPECT_GT(stamp.utime, last);
    EXPECT_LT(std::abs(sensor.error(stamp)), 1500.0);
    last = stamp.utime;
  }
  EXPECT_TRUE(wrapped);
}

TEST(DeviceClock, AStalledLinkIsNoJumpAndLeavesNoTrace) {
  Simulation sensor;
  sensor.synchronise();
  for (int i = 0; i < 400; ++i) {
    sensor.scan();
  }
  // 0.8 s of scans arrive at once.
  const common::Utime arrival = sensor.host + 32 * kScan + kSweep + kLink;
  for (int i = 0; i < 32; ++i) {
    sensor.host += kScan;
    const DeviceClock::Stamp stamp = sensor.clock.observe(sensor.deviceMs(sensor.host), arrival);
    EXPECT_FALSE(stamp.jumped);
    EXPECT_LT(std::abs(sensor.error(stamp)), 1500.0);
  }
}

TEST(DeviceClock, FirstScansThatWaitedInTheHostAreNoJump) {
  for (const bool synchronised : {false, true}) {
    Simulation sensor;
    if (synchronised) {
      sensor.synchronise();
    }
    const common::Utime arrival = sensor.host + 12 * kScan + kSweep + kLink;
    DeviceClock::Stamp stamp;
    for (int i = 0; i < 400; ++i) {
      sensor.host += kScan;
      stamp =
          sensor.clock.observe(sensor.deviceMs(sensor.host), std::max(arrival, sensor.host + kSweep + kLink));
      ASSERT_FALSE(stamp.jumped) << i;
    }
    EXPECT_LT(std::abs(sensor.error(stamp)), 1500.0);
  }
}

class DeviceClockJump : public testing::TestWithParam<std::int64_t> {};

TEST_P(DeviceClockJump, IsNoticedAtOnceAndTheStampsStayRight) {
  Simulation sensor;
  sensor.synchronise();
  common::Utime last = 0;
  for (int i = 0; i < 400; ++i) {
    last = sensor.scan().utime;
  }
  sensor.clock_begin_us += GetParam();
  DeviceClock::Stamp stamp = sensor.scan();
  EXPECT_TRUE(stamp.jumped);
  EXPECT_EQ(stamp.elapsed_ms, 0);
  for (int i = 0; i < 400; ++i) {
    EXPECT_GT(stamp.utime, last);
    last = stamp.utime;
    stamp = sensor.scan();
    ASSERT_FALSE(stamp.jumped);
  }
  EXPECT_LT(std::abs(sensor.error(stamp)), 2000.0);
}

INSTANTIATE_TEST_SUITE_P(Microseconds, DeviceClockJump,
                         testing::Values(5 * kSecond, 3600 * kSecond, 200'000, -100'000, -100 * kSecond));

TEST(DeviceClock, AHostClockThatIsSetForwardIsNoticedWithinSeconds) {
  Simulation sensor;
  sensor.synchronise();
  for (int i = 0; i < 400; ++i) {
    sensor.scan();
  }
  constexpr common::Utime kStep = 10 * kSecond;
  bool noticed = false;
  for (int i = 0; i < 10 * 40; ++i) {
    sensor.host += kScan;
    const DeviceClock::Stamp stamp =
        sensor.clock.observe(sensor.deviceMs(sensor.host), sensor.host + sensor.delay() + kStep);
    noticed |= stamp.jumped;
    if (i > 6 * 40) {
      EXPECT_LT(std::abs(sensor.error(stamp) - kStep), 2500.0);
    }
  }
  EXPECT_TRUE(noticed);
}

TEST(DeviceClock, AHostClockThatIsSetBackTakesTheStampsWithIt) {
  Simulation sensor;
  sensor.synchronise();
  for (int i = 0; i < 400; ++i) {
    sensor.scan();
  }
  constexpr common::Utime kStep = -10 * kSecond;
  sensor.host += kScan;
  const DeviceClock::Stamp stamp =
      sensor.clock.observe(sensor.deviceMs(sensor.host), sensor.host + kSweep + kLink + kStep);
  EXPECT_TRUE(stamp.jumped);
  EXPECT_LT(std::abs(sensor.error(stamp) - kStep), 2000.0);
}

TEST(DeviceClock, ElapsedTimeIsTheSensors) {
  DeviceClock clock(0);
  EXPECT_EQ(clock.observe(DeviceClock::kWrapMs - 10, kEpoch).elapsed_ms, 0);
  EXPECT_EQ(clock.observe(15, kEpoch + 25'000).elapsed_ms, 25);
  EXPECT_EQ(clock.observe(90, kEpoch + 100'000).elapsed_ms, 75);
}

}  // namespace
}  // namespace rubble::lidar
