#include "device/scan_queue.h"

#include <gtest/gtest.h>

namespace rubble::lidar {
namespace {

TEST(ScanQueue, KeepsOrderAndDropsTheOldest) {
  ScanQueue queue;
  LidarScan scan;
  EXPECT_FALSE(queue.pop(scan));
  constexpr auto kPushed = static_cast<common::Utime>(ScanQueue::kCapacity) + 3;
  for (common::Utime utime = 1; utime <= kPushed; ++utime) {
    scan.utime = utime;
    queue.push(scan);
  }
  EXPECT_EQ(queue.dropped(), 3);
  for (common::Utime utime = 4; utime <= kPushed; ++utime) {
    ASSERT_TRUE(queue.pop(scan));
    EXPECT_EQ(scan.utime, utime);
  }
  EXPECT_FALSE(queue.pop(scan));
}

}  // namespace
}  // namespace rubble::lidar
