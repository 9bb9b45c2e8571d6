// The emulator against answers that stand in the specification, so that driver and emulator do not merely
// agree.
#include "emulated_sensor.h"

#include <gmock/gmock.h>

#include <limits>

#include "support/error_text.h"

namespace rubble::lidar {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

const EmulatedModel kThreeBeams{.beams = 3, .rad0 = -0.004363323129985824, .rate = 40.0};

EmulatedScan scanOf(std::vector<float> ranges) {
  return {.since_first = {}, .ranges = std::move(ranges), .intensities = {}};
}

TEST(EmulatedSensor, AnswersInTheSpecificationsForm) {
  EmulatedSensor sensor(kThreeBeams);
  EXPECT_EQ(sensor.receive("QT\n", 0), "QT\n00P\n\n");
  EXPECT_EQ(sensor.receive("BM\r", 0), "BM\n00P\n\n");
  EXPECT_EQ(sensor.receive("BM\n", 0), "BM\n02R\n\n");
  EXPECT_EQ(sensor.receive("TM1\n", 0), "TM1\n04T\n\n");
  EXPECT_EQ(sensor.receive("TM0\n", 0), "TM0\n00P\n\n");
  EXPECT_EQ(sensor.receive("TM1;abc\n", 16'000'000), "TM1;abc\n00P\nm2@0?\n\n");
  EXPECT_EQ(sensor.receive("VV\n", 0), "VV\n0Bb\n\n") << "nothing else while it adjusts its time";
  EXPECT_EQ(sensor.receive("TM2\n", 0), "TM2\n00P\n\n");
  EXPECT_EQ(sensor.receive("XX\n", 0), "XX\n0Ee\n\n");
  EXPECT_THAT(sensor.receive("VV\n", 0), HasSubstr("PROT:SCIP 2.0;N\n"));
  EXPECT_THAT(sensor.receive("PP\n", 0), HasSubstr("DMIN:23;7\nDMAX:60000;J\nARES:1440;^\nAMIN:0;?\n"));
  EXPECT_THAT(sensor.receive("II\n", 0x123456), HasSubstr("TIME:123456;"));
}

TEST(EmulatedSensor, SendsScansAsHandComputed) {
  EmulatedSensor sensor(kThreeBeams);
  EXPECT_EQ(sensor.scan(scanOf({1, 1, 1}), 0), "") << "nobody asked";
  EXPECT_EQ(sensor.receive("MD0000000201002\n", 0), "MD0000000201002\n00P\n\n");
  const EmulatedScan scan = scanOf({5.432F, std::numeric_limits<float>::quiet_NaN(), 1.234F});
  EXPECT_EQ(sensor.scan(scan, 16'000'000), "MD0000000201001\n99b\nm2@0?\n1Dh0010CBS\n\n");
  EXPECT_THAT(sensor.scan(scan, 0), StartsWith("MD0000000201000\n"));
  EXPECT_EQ(sensor.scan(scan, 0), "") << "two were asked for";
}

TEST(EmulatedSensor, RefusesAsTheSpecificationSays) {
  EmulatedSensor sensor(kThreeBeams);
  for (const auto& [command, status] :
       std::vector<std::pair<std::string, std::string>>{{"MDx000000201000", "01"},
                                                        {"MD0000x00201000", "02"},
                                                        {"MD00000002x1000", "03"},
                                                        {"MD0000000301000", "04"},
                                                        {"MD0002000101000", "05"},
                                                        {"MD0000000201x00", "06"},
                                                        {"MD00000002010x0", "07"},
                                                        {"MD0000", "0C"}}) {
    EXPECT_THAT(sensor.receive(command + "\n", 0), StartsWith(command + "\n" + status)) << command;
  }
}

TEST(EmulatedSensor, SkipsAndClusters) {
  EmulatedSensor sensor({.beams = 4, .rad0 = 0.0, .rate = 40.0});
  sensor.receive("MD0000000302100\n", 0);
  const EmulatedScan scan = scanOf({5.0F, 1.234F, 5.432F, 9.0F});
  EXPECT_THAT(sensor.scan(scan, 0), HasSubstr("\n0CB1Dh"));
  EXPECT_EQ(sensor.scan(scan, 0), "");
  EXPECT_NE(sensor.scan(scan, 0), "");
}

TEST(EmulatedSensor, BrokenItScansOnlyAfterAReset) {
  EmulatedSensor sensor(kThreeBeams);
  sensor.receive("MD0000000201000\n", 0);
  EXPECT_THAT(sensor.breakDown(), StartsWith("MD0000000201000\n0L"));
  EXPECT_EQ(sensor.scan(scanOf({1, 1, 1}), 0), "");
  EXPECT_THAT(sensor.receive("BM\n", 0), StartsWith("BM\n01"));
  EXPECT_THAT(sensor.receive("MD0000000201000\n", 0), StartsWith("MD0000000201000\n0L"));
  sensor.receive("RS\n", 0);
  EXPECT_THAT(sensor.receive("BM\n", 0), StartsWith("BM\n00"));
}

TEST(ParseFault, NamesWhatThereIs) {
  EXPECT_EQ(parseFault("clock-wrap"), Fault::kClockWrap);
  EXPECT_THAT(test::errorOf([] { parseFault("fire"); }),
              HasSubstr("`fire` is no fault; there are cut, checksum"));
}

}  // namespace
}  // namespace rubble::lidar
