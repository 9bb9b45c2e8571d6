#include "protocol/set_points.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace rubble::stabilizer {
namespace {

using common::Utime;

constexpr Utime kStart = 1'700'000'000'000'000;
constexpr Utime kCycle = 10'000;
constexpr SetPoints::Limits kLimits{.lowest = {-0.35, -0.3}, .highest = {0.35, 0.3}, .rate = {2.5, 2.0}};

SetPoints atZero() {
  SetPoints points(kLimits);
  points.hold({0.0, 0.0}, kStart);
  return points;
}

TEST(SetPoints, HoldsWithoutACommand) {
  SetPoints points(kLimits);
  points.hold({0.1, -0.2}, kStart);
  EXPECT_EQ(points.advance(kStart + 1'000'000), (PerAxis{0.1, -0.2}));
  EXPECT_FALSE(points.follows(kStart));
}

TEST(SetPoints, ReachesTheAnglesAtTheirTimeAndWithTheirRate) {
  SetPoints points = atZero();
  ASSERT_TRUE(points.command({kStart + 200'000, kStart + 400'000, {0.1, -0.1}, {0.2, 0.0}}, kStart));
  Utime now = kStart;
  while (now < kStart + 200'000) {
    points.advance(now += kCycle);
  }
  EXPECT_NEAR(points.advance(now)[0], 0.1, 1e-9);
  EXPECT_NEAR(points.advance(now)[1], -0.1, 1e-9);
  const double before = points.advance(now)[0];
  EXPECT_NEAR(points.advance(now + kCycle)[0] - before, 0.2 * 0.01, 1e-9) << "goes on with its rate";
}

TEST(SetPoints, StartsSmoothly) {
  SetPoints points = atZero();
  points.command({kStart + 500'000, kStart + 600'000, {0.2, 0.2}, {}}, kStart);
  EXPECT_LT(points.advance(kStart + kCycle)[0], 0.2 / 50 / 5) << "the cubic begins with the plate's own rate";
}

TEST(SetPoints, GoesOnWithTheRateUntilItExpiresThenHolds) {
  SetPoints points = atZero();
  points.command({kStart, kStart + 100'000, {0.0, 0.0}, {0.5, -0.5}}, kStart);
  Utime now = kStart;
  while (now < kStart + 100'000) {
    points.advance(now += kCycle);
    EXPECT_TRUE(points.follows(now));
  }
  const PerAxis last = points.advance(now);
  EXPECT_NEAR(last[0], 0.05, 1e-9);
  EXPECT_NEAR(last[1], -0.05, 1e-9);
  EXPECT_EQ(points.advance(now + 1), last);
  EXPECT_FALSE(points.follows(now + 1));
  EXPECT_EQ(points.advance(now + 5'000'000), last);
}

TEST(SetPoints, RefusesWhatIsExpiredOlderOrNoNumber) {
  SetPoints points = atZero();
  EXPECT_FALSE(points.command({kStart, kStart - 1, {}, {}}, kStart));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(points.command({kStart, kStart + 1000, {nan, 0.0}, {}}, kStart));
  EXPECT_FALSE(points.command({kStart, kStart + 1000, {}, {0.0, nan}}, kStart));
  EXPECT_TRUE(points.command({kStart + 10, kStart + 1000, {}, {}}, kStart));
  EXPECT_FALSE(points.command({kStart + 9, kStart + 1000, {}, {}}, kStart))
      << "they have overtaken each other";
  EXPECT_EQ(points.commandUtime(), kStart + 10);
  EXPECT_TRUE(points.command({kStart + 9, kStart + 3000, {}, {}}, kStart + 2000))
      << "the newer one has expired";
}

TEST(SetPoints, StopsAtTheLimitsAndSaysSo) {
  SetPoints points = atZero();
  points.command({kStart, kStart + 2'000'000, {1.0, 0.0}, {0.0, 0.1}}, kStart);
  Utime now = kStart;
  for (int i = 0; i < 100; ++i) {
    points.advance(now += kCycle);
  }
  EXPECT_EQ(points.advance(now)[0], 0.35);
  EXPECT_TRUE(points.limited(0));
  EXPECT_FALSE(points.limited(1));
  points.command({now, now + 2'000'000, {0.1, 0.0}, {}}, now);
  points.advance(now + kCycle);
  EXPECT_FALSE(points.limited(0));
}

TEST(SetPoints, APlateFoundOutsideItsRangeIsNotJerked) {
  SetPoints points(kLimits);
  points.hold({0.5, 0.0}, kStart);
  EXPECT_EQ(points.advance(kStart + kCycle)[0], 0.5);
  points.command({kStart + kCycle, kStart + 2'000'000, {0.0, 0.0}, {}}, kStart + kCycle);
  EXPECT_NEAR(points.advance(kStart + 2 * kCycle)[0], 0.5 - 0.025, 1e-9) << "comes in at the rate's limit";
}

TEST(SetPoints, AClockSetBackOrForwardMovesNothingByItself) {
  SetPoints points = atZero();
  points.command({kStart, kStart + 100'000, {0.3, 0.0}, {}}, kStart);
  points.advance(kStart + kCycle);
  const double before = points.advance(kStart + 2 * kCycle)[0];
  EXPECT_EQ(points.advance(kStart - 3'600'000'000)[0], before);
  EXPECT_EQ(points.advance(kStart + 3'600'000'000)[0], before) << "expired";
  const Utime back = kStart - 3'600'000'000;
  EXPECT_TRUE(points.command({back, back + 100'000, {0.1, 0.0}, {}}, back))
      << "not taken for one that came late";
}

/// Whatever comes: in range, and never faster than the limit.
TEST(SetPoints, AreBoundedWhateverIsCommanded) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  SetPoints points = atZero();
  Utime now = kStart;
  PerAxis last{};
  for (int i = 0; i < 200'000; ++i) {
    if (unit(random) > 0.7) {
      const auto shift = static_cast<Utime>(3e5 * unit(random));
      const double scale = std::pow(10.0, 3.0 * unit(random));
      points.command({now + shift,
                      now + static_cast<Utime>(5e5 * (unit(random) + 0.5)),
                      {scale * unit(random), unit(random)},
                      {scale * unit(random), 10.0 * unit(random)}},
                     now);
    }
    const auto step = static_cast<Utime>(1e4 * (1.0 + unit(random)));
    const PerAxis angles = points.advance(now += step);
    for (std::size_t k = 0; k < 2; ++k) {
      ASSERT_TRUE(angles[k] >= kLimits.lowest[k] && angles[k] <= kLimits.highest[k]) << i;
      ASSERT_LE(std::abs(angles[k] - last[k]), kLimits.rate[k] * common::secondsFromUtime(step) + 1e-12) << i;
    }
    last = angles;
  }
}

/// As fusion does it: 100 commands a second of a swinging robot, each valid for 0.1 s.
TEST(SetPoints, FollowASineOfCommands) {
  const auto angle = [](Utime t) {
    return 0.2 * std::sin(2.0 * M_PI * 0.5 * common::secondsFromUtime(t - kStart));
  };
  const auto rate = [](Utime t) {
    return 0.2 * M_PI * std::cos(2.0 * M_PI * 0.5 * common::secondsFromUtime(t - kStart));
  };
  for (const Utime lead : {Utime{0}, Utime{30'000}}) {
    SetPoints points = atZero();
    double worst = 0.0;
    for (int i = 1; i < 400; ++i) {
      const Utime now = kStart + i * kCycle;
      const Utime at = now + lead;
      points.command({at, at + 100'000, {angle(at), 0.0}, {rate(at), 0.0}}, now);
      const double error = points.advance(now + 3000)[0] - angle(now + 3000);
      worst = i > 50 ? std::max(worst, std::abs(error)) : 0.0;
    }
    EXPECT_LT(worst, 0.003) << lead;
  }
}

}  // namespace
}  // namespace rubble::stabilizer
