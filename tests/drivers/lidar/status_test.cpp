#include "protocol/status.h"

#include <gtest/gtest.h>

namespace rubble::lidar {
namespace {

TEST(ScipStatus, KindsAsInTheSpecification) {
  EXPECT_EQ(kindOf("00"), StatusKind::kDone);
  EXPECT_EQ(kindOf("99"), StatusKind::kScan);
  for (const char* status : {"21", "49", "98"}) {
    EXPECT_EQ(kindOf(status), StatusKind::kVerifying) << status;
  }
  for (const char* status : {"50", "97", "0L", "0M"}) {
    EXPECT_EQ(kindOf(status), StatusKind::kMalfunction) << status;
  }
  for (const char* status : {"01", "10", "20", "0E", "zz", "", "0", "000"}) {
    EXPECT_EQ(kindOf(status), StatusKind::kRefused) << status;
  }
}

TEST(ScipStatus, SaysItInWords) {
  EXPECT_EQ(describeStatus("XY", "0E"), "status 0E (undefined command)");
  EXPECT_EQ(describeStatus("MD0000108001000", "04"), "status 04 (the last step is out of its range)");
  EXPECT_EQ(describeStatus("BM", "01"), "status 01 (it cannot switch its laser on: laser malfunction)");
  EXPECT_EQ(describeStatus("MD", "0L"), "status 0L (malfunction)");
  EXPECT_EQ(describeStatus("ME", "77"), "status 77 (hardware trouble: laser, motor or the like)");
  EXPECT_EQ(describeStatus("ME", "33"), "status 33 (it checks itself)");
  EXPECT_EQ(describeStatus("ME", "?!"), "status ?! (not in the specification)");
}

}  // namespace
}  // namespace rubble::lidar
