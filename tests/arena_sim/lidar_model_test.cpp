#include "lidar_model.h"

#include <gtest/gtest.h>

#include <cmath>

namespace rubble::arena_sim {
namespace {

using common::Pose2;

constexpr double kSweep = 0.01875;
constexpr double kTurning = 1.0;  // A moment of zigzag() at full turn rate.

class LidarModelTest : public testing::Test {
 protected:
  LidarModelTest() : arena_(makeArena(3)), caster_(arena_.segments) {
    Driver driver({});
    driver.turnTo(3.0);
    motion_ = driver.motion();
  }

  LidarModel model(const LidarModelConfig& config) const {
    return {config, caster_, motion_, T_body_lidar_, kSweep, 1};
  }

  double distanceToWall(const Eigen::Vector2d& p) const {
    double nearest = 1e9;
    for (const Segment& segment : arena_.segments) {
      nearest = std::min(nearest, distanceTo(segment, p));
    }
    return nearest;
  }

  const Arena arena_;
  const RayCaster caster_;
  const Pose2 T_body_lidar_{0.1, 0.05, 0.2};
  Motion motion_;
};

TEST_F(LidarModelTest, BeamsOfATurningSweepEndOnTheWalls) {
  const LidarModelConfig config;
  const LidarModel lidar = model(config);
  const auto ranges = lidar.trueRanges(kTurning);
  ASSERT_EQ(ranges.size(), 1081U);
  double worst_if_frozen = 0.0;
  for (int i = 0; i < config.beams; ++i) {
    const double angle = config.firstAngle() + i * config.angleStep();
    const Eigen::Vector2d p_lidar =
        ranges[static_cast<std::size_t>(i)] * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    const Pose2 T_world_body = motion_.at(kTurning + kSweep * i / config.beams);
    EXPECT_LT(distanceToWall(T_world_body * (T_body_lidar_ * p_lidar)), 1e-9);
    worst_if_frozen =
        std::max(worst_if_frozen, distanceToWall(motion_.at(kTurning) * (T_body_lidar_ * p_lidar)));
  }
  EXPECT_GT(worst_if_frozen, 0.03) << "the sweep must matter, or this test shows nothing";
}

TEST_F(LidarModelTest, NoiseAndDropoutsAreAsConfigured) {
  LidarModelConfig config;
  config.dropout_rate = 0.02;
  LidarModel lidar = model(config);
  const auto truth = lidar.trueRanges(0.0);
  double sum = 0.0;
  double squares = 0.0;
  int n = 0;
  int dropped = 0;
  for (int scan = 0; scan < 50; ++scan) {
    const auto ranges = lidar.measure(0.0);
    for (std::size_t i = 0; i < ranges.size(); ++i) {
      if (std::isnan(ranges[i])) {
        ++dropped;
        continue;
      }
      const double error = static_cast<double>(ranges[i]) - truth[i];
      sum += error;
      squares += error * error;
      ++n;
    }
  }
  EXPECT_NEAR(sum / n, 0.0, 0.0005);
  EXPECT_NEAR(std::sqrt(squares / n), config.range_sigma, 0.0005);
  EXPECT_NEAR(static_cast<double>(dropped) / (n + dropped), config.dropout_rate, 0.003);
}

TEST_F(LidarModelTest, NothingReturnsFromOutsideTheLimits) {
  LidarModelConfig config;
  config.min_range = 1.0;
  config.max_range = 3.0;
  LidarModel lidar = model(config);
  int returned = 0;
  for (const float range : lidar.measure(0.0)) {
    if (!std::isnan(range)) {
      EXPECT_GE(range, 0.999F);
      EXPECT_LE(range, 3.001F);
      ++returned;
    }
  }
  EXPECT_GT(returned, 100);
}

}  // namespace
}  // namespace rubble::arena_sim
