#include "sensors/lidar_model.h"

#include <gtest/gtest.h>

#include <cmath>

#include "scene/mesh.h"

namespace rubble::arena_sim {
namespace {

using common::Pose3;
using Eigen::Vector3d;

constexpr double kSweep = 0.01875;

/// A box of 6 x 4 x 3 m around the origin, its walls of one material.
Scene room(Material material) {
  Scene scene;
  addBox(scene.surfaces, Pose3::Identity(), {6.0, 4.0, 3.0}, {material, 1, nullptr}, false);
  return scene;
}

/// Metres from p, inside the room, along d to its walls.
double analyticRange(const Vector3d& p, const Vector3d& d) {
  const Vector3d half(3.0, 2.0, 1.5);
  double range = 1e9;
  for (int axis = 0; axis < 3; ++axis) {
    if (d[axis] != 0.0) {
      range = std::min(range, (std::copysign(half[axis], d[axis]) - p[axis]) / d[axis]);
    }
  }
  return range;
}

/// Drives, turns and tilts.
Pose3 moving(double seconds) {
  Pose3 T = Pose3::Identity();
  T.translation() = Vector3d(0.8 * seconds, 0.3, 0.1 * seconds);
  T.linear() = common::rotationFromRpy({0.2 * seconds, -0.3 * seconds, 2.0 * seconds});
  return T;
}

class LidarModelTest : public testing::Test {
 protected:
  LidarModel model(const LidarModelConfig& config, const PoseAt& pose) {
    return {config, kSweep, scene_, tracer_, pose, std::mt19937_64(1)};
  }
  static Pose3 standing(double) { return Pose3::Identity(); }

  const Scene scene_ = room(Material::kOsb);
  const RayTracer tracer_{scene_};
};

TEST_F(LidarModelTest, EachBeamOfAMovingSweepIsTheAnalyticOne) {
  const LidarModelConfig config;
  const LidarModel lidar = model(config, moving);
  constexpr double kStart = 0.4;
  double most_if_frozen = 0.0;
  for (int i = 0; i < config.beams; ++i) {
    const double angle = config.firstAngle() + i * config.angleStep();
    const Vector3d d_lidar(std::cos(angle), std::sin(angle), 0.0);
    const Pose3 T = moving(kStart + kSweep * i / config.beams);
    const double range = lidar.trueBeam(kStart, i).range;
    ASSERT_NEAR(range, analyticRange(T.translation(), T.linear() * d_lidar), 1e-5) << i;
    const Pose3 frozen = moving(kStart);
    most_if_frozen = std::max(
        most_if_frozen, std::abs(range - analyticRange(frozen.translation(), frozen.linear() * d_lidar)));
  }
  EXPECT_GT(most_if_frozen, 0.03) << "the sweep must matter, or this test shows nothing";
}

TEST_F(LidarModelTest, NoiseAndDropoutsAreAsConfigured) {
  LidarModelConfig config;
  config.dropout_rate = 0.02;
  config.mixed_share = 0.0;
  LidarModel lidar = model(config, standing);
  double sum = 0.0;
  double squares = 0.0;
  int n = 0;
  int dropped = 0;
  for (int scan = 0; scan < 30; ++scan) {
    const auto ranges = lidar.measure(0.0);
    for (int i = 0; i < config.beams; ++i) {
      const float range = ranges[static_cast<std::size_t>(i)];
      if (std::isnan(range)) {
        ++dropped;
        continue;
      }
      const double error = static_cast<double>(range) - lidar.trueBeam(0.0, i).range;
      sum += error;
      squares += error * error;
      ++n;
    }
  }
  EXPECT_NEAR(sum / n, 0.0, 0.0005);
  EXPECT_NEAR(std::sqrt(squares / n), config.range_sigma, 0.0005);
  EXPECT_NEAR(static_cast<double>(dropped) / (n + dropped), config.dropout_rate, 0.005);
}

TEST_F(LidarModelTest, NothingReturnsFromOutsideTheLimits) {
  LidarModelConfig config;
  config.min_range = 2.5;
  config.max_range = 3.2;
  LidarModel lidar = model(config, standing);
  int returned = 0;
  for (const float range : lidar.measure(0.0)) {
    if (!std::isnan(range)) {
      EXPECT_GE(range, 2.499F);
      EXPECT_LE(range, 3.201F);
      ++returned;
    }
  }
  EXPECT_GT(returned, 100);
  EXPECT_LT(returned, 1000);
}

TEST_F(LidarModelTest, DarkAndGlancingSurfacesDropOut) {
  const auto lost = [&](const Scene& scene, const LidarModelConfig& config) {
    const RayTracer tracer(scene);
    LidarModel lidar(config, kSweep, scene, tracer, standing, std::mt19937_64(1));
    int n = 0;
    for (const float range : lidar.measure(0.0)) {
      n += std::isnan(range) ? 1 : 0;
    }
    return n;
  };
  LidarModelConfig config;
  config.weakest_signal = 0.02;  // 10 % at 2.2 m
  EXPECT_LT(lost(scene_, config), 100);
  EXPECT_GT(lost(room(Material::kRubber), config), 300);
}

TEST_F(LidarModelTest, EdgesMixRanges) {
  Scene scene = room(Material::kOsb);
  Pose3 T = Pose3::Identity();
  T.translation() = Vector3d(1.0, 0.0, 0.0);
  addBox(scene.surfaces, T, {0.02, 0.5, 1.0}, {Material::kOsb, 2, nullptr}, false);
  const RayTracer tracer(scene);
  LidarModelConfig config;
  config.range_sigma = 0.0;
  config.mixed_share = 1.0;
  config.divergence = 2.0 * config.angleStep();
  LidarModel lidar(config, kSweep, scene, tracer, standing, std::mt19937_64(1));
  int between = 0;
  for (const float range : lidar.measure(0.0)) {
    between += range > 1.1F && range < 1.9F ? 1 : 0;
  }
  EXPECT_GE(between, 1);
  EXPECT_LE(between, 4) << "only the beams on the two edges of the board";
}

}  // namespace
}  // namespace rubble::arena_sim
