#include "stabilizer_config.h"

#include <gmock/gmock.h>

#include <cmath>

#include "support/error_text.h"

namespace rubble::stabilizer {
namespace {

using testing::HasSubstr;

std::string errorOfOverride(const std::string& assignment) {
  return test::errorOf([&] {
    common::Config config;
    config.addOverride(assignment);
    config.read<StabilizerConfig>("stabilizer");
  });
}

TEST(StabilizerConfig, UnitsOfTheDrive) {
  StabilizerConfig config = common::Config().read<StabilizerConfig>("stabilizer");
  config.roll = {.node = 3, .counts_per_turn = 1000, .gear = 2.0 * M_PI, .rate = 2.0};
  config.pitch.reversed = true;
  config.mode = "pp";
  config.following_error = 0.1;
  const StabilizerDriver::Options options = driverOptions(config);
  const AxisOptions& roll = options.pair.axes[0];
  EXPECT_NEAR(roll.rad_per_increment, 1e-3, 1e-12);
  EXPECT_EQ(roll.drive.setup.node, 3);
  EXPECT_EQ(roll.drive.setup.mode, Mode::kProfilePosition);
  EXPECT_EQ(roll.drive.setup.profile_velocity, 2000U);
  EXPECT_EQ(roll.drive.following_error, 100);
  EXPECT_LT(options.pair.axes[1].rad_per_increment, 0.0);
}

TEST(StabilizerConfig, WhatIsWrongIsNamed) {
  EXPECT_THAT(errorOfOverride("stabilizer.mode=torque"), HasSubstr("stabilizer.mode"));
  EXPECT_THAT(errorOfOverride("stabilizer.roll.node=2"), HasSubstr("are both 2"));
  EXPECT_THAT(errorOfOverride("stabilizer.roll.node=128"), HasSubstr("stabilizer.roll.node"));
  EXPECT_THAT(errorOfOverride("stabilizer.pitch.lowest=0.4"),
              HasSubstr("stabilizer.pitch.lowest = 0.4 is not below stabilizer.pitch.highest = 0.35"));
  EXPECT_THAT(errorOfOverride("stabilizer.roll.gear=10000"), HasSubstr("(no error)"));
  EXPECT_THAT(errorOfOverride("stabilizer.heartbeat_ms=350"),
              HasSubstr("heartbeat_timeout = 0.35 s is not above"));
  EXPECT_THAT(errorOfOverride("stabilizer.first_pause=6"), HasSubstr("stabilizer.first_pause = 6 is above"));
  EXPECT_THAT(errorOfOverride("stabilizer.interface=a-name-that-is-too-long"), HasSubstr("write e.g. can0"));
}

TEST(StabilizerConfig, AnglesStayWithin32Bits) {
  common::Config config;
  config.addOverride("stabilizer.roll.gear=10000");
  config.addOverride("stabilizer.roll.counts_per_turn=16777216");
  EXPECT_THAT(test::errorOf([&] { config.read<StabilizerConfig>("stabilizer"); }), HasSubstr("32 bits"));
}

}  // namespace
}  // namespace rubble::stabilizer
