#include "common/statistics.h"

#include <gtest/gtest.h>

#include <cmath>

namespace rubble::common {
namespace {

TEST(StatisticsTest, ByHand) {
  const Statistics s = statisticsOf({4.0, 1.0, 3.0, 2.0});
  EXPECT_DOUBLE_EQ(s.mean, 2.5);
  EXPECT_DOUBLE_EQ(s.median, 2.5);
  EXPECT_DOUBLE_EQ(s.rmse, std::sqrt(7.5));
  EXPECT_DOUBLE_EQ(s.std, std::sqrt(1.25));
  EXPECT_DOUBLE_EQ(s.max, 4.0);
  EXPECT_TRUE(std::isnan(statisticsOf({}).mean));
}

TEST(StatisticsTest, QuantilesAreInterpolated) {
  EXPECT_DOUBLE_EQ(quantileOf({3.0, 1.0, 2.0}, 0.5), 2.0);
  EXPECT_DOUBLE_EQ(quantileOf({0.0, 10.0}, 0.95), 9.5);
  EXPECT_DOUBLE_EQ(quantileOf({4.0}, 0.95), 4.0);
  EXPECT_TRUE(std::isnan(quantileOf({}, 0.5)));
}

}  // namespace
}  // namespace rubble::common
