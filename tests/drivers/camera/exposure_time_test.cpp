#include "exposure_time.h"

#include <gtest/gtest.h>

#include <vector>

namespace rubble::camera {
namespace {

constexpr std::int64_t kOffset = 1'700'000'000'000'000'000;

TEST(MidExposure, LiesHalfTheExposureFromItsStartOrEnd) {
  EXPECT_EQ(midExposure({5'000'000'000, true}, 0.01, 0.0, kOffset), 1'700'000'005'005'000);
  EXPECT_EQ(midExposure({5'000'000'000, false}, 0.01, 0.0, kOffset), 1'700'000'004'995'000);
  EXPECT_EQ(midExposure({5'000'000'000, false}, 0.0, 0.0, kOffset), 1'700'000'005'000'000);
}

TEST(MidExposure, TakesOffTheDelayOfTheStamp) {
  EXPECT_EQ(midExposure({5'000'000'000, true}, 0.0, 0.003, kOffset), 1'700'000'004'997'000);
  EXPECT_EQ(midExposure({5'000'000'000, false}, 0.01, 0.003, kOffset), 1'700'000'004'992'000);
}

TEST(ClockOffset, IsThatOfTheShortestReading) {
  const std::vector<ClockReading> readings{{1000, kOffset + 90'000, 100'000},
                                           {200'000, kOffset + 200'050, 200'100},
                                           {300'000, kOffset + 300'000, 700'000}};
  EXPECT_EQ(clockOffset(readings), kOffset);
}

TEST(Plausible, StampsAreOfTheLastOrNextSecond) {
  EXPECT_TRUE(isPlausible(5'000'000'000, 5'030'000'000));
  EXPECT_TRUE(isPlausible(5'036'000'000, 5'000'000'000))
      << "vivid stamps the end of a frame it has just begun";
  EXPECT_FALSE(isPlausible(0, 5'000'000'000));
  EXPECT_FALSE(isPlausible(kOffset, 5'000'000'000)) << "the epoch's clock";
}

}  // namespace
}  // namespace rubble::camera
