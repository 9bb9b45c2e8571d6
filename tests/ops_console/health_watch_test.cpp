#include "health_watch.h"

#include <gtest/gtest.h>

namespace rubble::ops_console {
namespace {

constexpr common::Utime kSecond = common::kMicrosecondsPerSecond;

TEST(HealthWatch, NamesWhoIsSilentAndWhoIsNotWell) {
  HealthWatch watch;
  watch.update("lidar", "", 0);
  watch.update("fusion", "is degraded (waiting): no SCAN", 0);
  EXPECT_EQ(watch.problems(kSecond), std::vector<std::string>{"fusion is degraded (waiting): no SCAN"});
  watch.update("fusion", "", 3 * kSecond);
  EXPECT_TRUE(watch.problems(3 * kSecond).empty());
  EXPECT_EQ(watch.problems(5 * kSecond), std::vector<std::string>{"lidar is silent for 5 s"});
  watch.update("lidar", "", 6 * kSecond);
  EXPECT_TRUE(watch.problems(6 * kSecond).empty());
}

}  // namespace
}  // namespace rubble::ops_console
