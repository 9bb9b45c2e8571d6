#include "lidar_config.h"

#include <gmock/gmock.h>

#include "support/error_text.h"
#include "support/temp_dir.h"

namespace rubble::lidar {
namespace {

using testing::HasSubstr;

std::string errorOfOverride(const std::string& assignment) {
  return test::errorOf([&] {
    common::Config config;
    config.addOverride(assignment);
    config.read<LidarConfig>("lidar");
  });
}

TEST(LidarConfig, DefaultsAreValid) {
  const LidarConfig config = common::Config().read<LidarConfig>("lidar");
  EXPECT_EQ(config.connection, "tcp://192.168.0.10:10940");
}

TEST(LidarConfig, BadAddressesSayHowToWriteThem) {
  for (const char* address : {"192.168.0.10", "tcp://192.168.0.10", "tcp://:10940", "tcp://host:0",
                              "tcp://host:x", "tcp://host:70000", "serial://ttyACM0", "/dev/ttyACM0"}) {
    EXPECT_THAT(errorOfOverride(std::string("lidar.connection=") + address),
                HasSubstr("is no address of a LiDAR; write tcp://HOST:PORT"))
        << address;
  }
}

TEST(LidarConfig, GoodAddressesAreTaken) {
  for (const char* address : {"tcp://192.168.0.10:10940", "tcp://lidar.local:1", "serial:///dev/ttyACM0"}) {
    EXPECT_EQ(errorOfOverride(std::string("lidar.connection=") + address), "(no error)");
  }
}

TEST(LidarConfig, WhatIsWrongIsNamed) {
  EXPECT_THAT(errorOfOverride("lidar.baud=115201"), HasSubstr("lidar.baud = 115201: use 19200,"));
  EXPECT_THAT(errorOfOverride("lidar.cluster=0"), HasSubstr("lidar.cluster"));
  EXPECT_THAT(errorOfOverride("lidar.first_angle=3"), HasSubstr("(no error)"));
  EXPECT_THAT(errorOfOverride("lidar.last_angle=-3.2"), HasSubstr("lidar.first_angle = -3.2 is not below"));
  EXPECT_THAT(errorOfOverride("lidar.first_pause=6"), HasSubstr("lidar.first_pause = 6 is above"));
}

TEST(LidarConfig, AMisspeltKeyIsNamedWithItsPlace) {
  const test::TempDir dir;
  const auto file = dir.write("lidar.yaml", "lidar:\n  conection: tcp://host:1\n");
  EXPECT_THAT(test::errorOf([&] {
                common::Config config;
                config.addFile(file);
                config.read<LidarConfig>("lidar");
              }),
              HasSubstr("lidar.yaml:2: unknown key `conection`"));
}

}  // namespace
}  // namespace rubble::lidar
