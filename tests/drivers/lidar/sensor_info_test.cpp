#include "protocol/sensor_info.h"

#include <gmock/gmock.h>

#include <cmath>

#include "protocol/scan_request.h"
#include "support/error_text.h"

namespace rubble::lidar {
namespace {

using test::errorOf;
using testing::HasSubstr;

// As a UTM-30LX-EW answers.
constexpr char kParameters[] =
    "MODL:UTM-30LX-EW;I\nDMIN:23;7\nDMAX:60000;J\nARES:1440;^\nAMIN:0;?\nAMAX:1080;Z\nAFRT:540;0\nSCAN:2400;"
    "U\n";

SensorInfo utm30() {
  SensorInfo info;
  EXPECT_TRUE(readFields(kParameters, info));
  return info;
}

TEST(SensorInfo, ReadsWhatARealSensorSends) {
  const SensorInfo info = utm30();
  checkParameters(info);
  EXPECT_EQ(info.model, "UTM-30LX-EW");
  EXPECT_EQ(info.min_range_mm, 23);
  EXPECT_EQ(info.max_range_mm, 60'000);
  EXPECT_EQ(info.steps_per_turn, 1440);
  EXPECT_EQ(info.last_step, 1080);
  EXPECT_EQ(info.front_step, 540);
  EXPECT_NEAR(info.angleOf(0), -0.75 * M_PI, 1e-12);
  EXPECT_NEAR(info.angleOf(1080), 0.75 * M_PI, 1e-12);
  EXPECT_DOUBLE_EQ(info.turnTime(), 0.025);
}

TEST(SensorInfo, ADamagedLineIsNoticed) {
  SensorInfo info;
  EXPECT_FALSE(readFields("DMIN:24;7\nDMAX:60000;J\n", info));
  EXPECT_EQ(info.min_range_mm, 0);
  EXPECT_EQ(info.max_range_mm, 60'000);
  for (const char* line : {"\n", ";\n", ":;", "DMIN:23;", "DMIN;237\n", "no colon;x\n"}) {
    EXPECT_FALSE(readFields(line, info)) << line;
  }
}

TEST(SensorInfo, MissingAndAbsurdParametersAreNamed) {
  SensorInfo info = utm30();
  info.rpm = 0;
  EXPECT_EQ(errorOf([&] { checkParameters(info); }),
            "tells no SCAN within 1 .. 100000 (PP); is it a SCIP 2.0 LiDAR?");
  info = utm30();
  info.first_step = 1081;
  EXPECT_THAT(errorOf([&] { checkParameters(info); }), HasSubstr("contradict"));
  EXPECT_THAT(errorOf([&] { checkParameters(SensorInfo()); }), HasSubstr("DMAX"));
}

TEST(ScanRequest, TakesWhatTheSensorSees) {
  const ScanRequest request = requestFor(utm30(), {.first_angle = -3.2, .last_angle = 3.2});
  EXPECT_EQ(commandOf(request), "MD0000108001000");
  EXPECT_EQ(request.beams(), 1081);
}

TEST(ScanRequest, AnAngleThatNamesAStepIncludesIt) {
  const ScanRequest request =
      requestFor(utm30(), {.first_angle = -M_PI / 2, .last_angle = M_PI / 2, .skip = 3, .intensities = true});
  EXPECT_EQ(commandOf(request), "ME0180090001300");
}

TEST(ScanRequest, OnlyWholeClusters) {
  const ScanRequest request = requestFor(utm30(), {.first_angle = -3.2, .last_angle = 3.2, .cluster = 2});
  EXPECT_EQ(commandOf(request), "MD0000107902000");
  EXPECT_EQ(request.beams(), 540);
}

TEST(ScanRequest, NothingLeftIsAnError) {
  EXPECT_EQ(
      errorOf([] { requestFor(utm30(), {.first_angle = 2.5, .last_angle = 3.0}); }),
      "has fewer than two beams between lidar.first_angle = 2.5 and lidar.last_angle = 3; it sees -2.356 .. "
      "2.356 rad");
}

}  // namespace
}  // namespace rubble::lidar
