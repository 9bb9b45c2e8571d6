#include "truth/truth_recorder.h"

#include <gtest/gtest.h>

#include <numbers>

namespace rubble::arena_sim {
namespace {

common::Pose3 lidarAt(double z, double roll, double pitch) {
  common::Pose3 T = common::pose3FromPose2({1.0, 2.0, 0.7}, z);
  T.linear() = common::rotationFromRpy({roll, pitch, 0.7});
  return T;
}

TEST(LidarState, IsHOnlyLevelAndAtTheLevelsHeight) {
  const TruthConfig config;
  constexpr double kHeight = 0.3;
  constexpr double kDegree = std::numbers::pi / 180.0;
  const auto usable = [&](double z, double roll, double pitch) {
    return lidarStateAt(config, lidarAt(z, roll * kDegree, pitch * kDegree), kHeight).is_usable;
  };
  EXPECT_TRUE(usable(kHeight, 0.0, 0.0));
  EXPECT_TRUE(usable(kHeight, 2.0, -2.0));
  EXPECT_FALSE(usable(kHeight, 2.2, -2.2)) << "3.1 degrees of tilt";
  EXPECT_FALSE(usable(kHeight, 0.0, 3.1));
  EXPECT_TRUE(usable(kHeight + 0.24, 0.0, 0.0));
  EXPECT_FALSE(usable(kHeight + 0.26, 0.0, 0.0));
  EXPECT_NEAR(lidarStateAt(config, lidarAt(1.5, 0.0, 0.1), kHeight).tilt, 0.1, 1e-9);
  EXPECT_NEAR(lidarStateAt(config, lidarAt(1.5, 0.0, 0.1), kHeight).height, 1.2, 1e-9);
}

}  // namespace
}  // namespace rubble::arena_sim
