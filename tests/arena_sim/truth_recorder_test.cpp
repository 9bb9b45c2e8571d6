#include "truth/truth_recorder.h"

#include <gtest/gtest.h>

#include <array>
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
  const std::array floors{0.0, 1.2};
  const auto stateAt = [&](double z, double roll, double pitch) {
    return lidarStateAt(config, lidarAt(z, roll * kDegree, pitch * kDegree), floors, kHeight);
  };
  const auto usable = [&](double z, double roll, double pitch) { return stateAt(z, roll, pitch).is_usable; };
  EXPECT_TRUE(usable(kHeight, 0.0, 0.0));
  EXPECT_TRUE(usable(kHeight, 2.0, -2.0));
  EXPECT_FALSE(usable(kHeight, 2.2, -2.2)) << "3.1 degrees of tilt";
  EXPECT_FALSE(usable(kHeight, 0.0, 3.1));
  EXPECT_TRUE(usable(kHeight + 0.24, 0.0, 0.0));
  EXPECT_FALSE(usable(kHeight + 0.26, 0.0, 0.0));
  EXPECT_NEAR(stateAt(1.5, 0.0, 6.0).tilt, 6.0 * kDegree, 1e-9);
  EXPECT_FALSE(usable(kHeight + 0.94, 0.0, 0.0)) << "between the levels";
  EXPECT_EQ(stateAt(kHeight + 0.59, 0.0, 0.0).level, 0U);
  EXPECT_EQ(stateAt(kHeight + 0.94, 0.0, 0.0).level, 1U);
  EXPECT_TRUE(usable(kHeight + 1.3, 0.0, 0.0));
  EXPECT_NEAR(stateAt(kHeight + 1.3, 0.0, 0.0).height, 0.1, 1e-9);
}

}  // namespace
}  // namespace rubble::arena_sim
