#include "geometry/pnp.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include "geometry/p3p.h"
#include "geometry_scene.h"

namespace rubble::slam_mono {
namespace {

/// Observations seen at T with a pixel of noise, the first ones anywhere else in the picture.
std::vector<PointObservation> observe(const Camera& camera, const common::Pose3& T, int count, int outliers,
                                      Dice& dice) {
  std::vector<PointObservation> observations;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector2d pixel = dice.pixel(camera);
    const Eigen::Vector3d p_camera = dice.uniform(1.0, 8.0) * camera.unproject(pixel);
    observations.push_back({T.inverse() * p_camera,
                            i < outliers ? dice.pixel(camera) : Eigen::Vector2d(pixel + dice.noise(1.0)),
                            1.0});
  }
  return observations;
}

struct Deviation {
  double position = 0.0;
  double angle = 0.0;

  void add(const common::Pose3& found, const common::Pose3& T) {
    position = std::max(position, (centreOf(found) - centreOf(T)).norm());
    angle = std::max(angle, rotationError(found, T));
  }
};

TEST(PnpTest, P3pFindsThePoseAmongItsSolutions) {
  Dice dice(1);
  int found = 0;
  for (int i = 0; i < 1000; ++i) {
    const common::Pose3 T = dice.pose(5.0, 3.0);
    std::array<Eigen::Vector3d, 3> points;
    std::array<Eigen::Vector3d, 3> bearings;
    for (std::size_t k = 0; k < 3; ++k) {
      // Every direction: as a fisheye may see them.
      bearings[k] = dice.vector(1.0).normalized();
      points[k] = T.inverse() * (dice.uniform(0.5, 10.0) * bearings[k]);
    }
    const P3pPoses poses = solveP3p(points, bearings);
    double best = 1.0;
    for (int k = 0; k < poses.count; ++k) {
      const common::Pose3& T_found = poses.T_camera_world[static_cast<std::size_t>(k)];
      EXPECT_NEAR(T_found.linear().determinant(), 1.0, 1e-6);
      best = std::min(best, (T_found.matrix() - T.matrix()).norm());
    }
    found += best < 1e-5 ? 1 : 0;
  }
  EXPECT_GE(found, 990);
}

TEST(PnpTest, P3pRefusesALine) {
  const std::array<Eigen::Vector3d, 3> line = {Eigen::Vector3d(0, 0, 3), Eigen::Vector3d(1, 0, 3),
                                               Eigen::Vector3d(2, 0, 3)};
  const std::array<Eigen::Vector3d, 3> bearings = {line[0].normalized(), line[1].normalized(),
                                                   line[2].normalized()};
  EXPECT_EQ(solveP3p(line, bearings).count, 0);
}

TEST(PnpTest, FindsThePoseBetweenSixtyPercentOutliers) {
  for (const Camera& camera : {arenaCamera(), fisheyeCamera()}) {
    Deviation worst;
    for (std::uint64_t seed = 1; seed <= 100; ++seed) {
      Dice dice(seed);
      const common::Pose3 T = dice.pose(4.0, 3.0);
      const auto observations = observe(camera, T, 200, 120, dice);
      PnpConfig config;
      config.seed = seed;
      const auto optimum = solvePnp(camera, observations, config);
      ASSERT_TRUE(optimum) << seed;
      worst.add(optimum->T_camera_mono, T);
      EXPECT_GT(optimum->inlier_count, 65);
      EXPECT_LT(std::count(optimum->inliers.begin(), optimum->inliers.begin() + 120, true), 5);
      EXPECT_EQ(std::count(optimum->inliers.begin(), optimum->inliers.end(), true), optimum->inlier_count);
      EXPECT_TRUE(optimum->covariance.allFinite());
    }
    EXPECT_LT(worst.position, 0.06);
    EXPECT_LT(worst.angle, 0.01);
  }
}

TEST(PnpTest, FindsThePoseBetweenSeventyPercentOutliers) {
  int found = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    Dice dice(seed);
    const common::Pose3 T = dice.pose(4.0, 3.0);
    const auto optimum = solvePnp(arenaCamera(), observe(arenaCamera(), T, 200, 140, dice), {});
    found += optimum && (centreOf(optimum->T_camera_mono) - centreOf(T)).norm() < 0.08 ? 1 : 0;
  }
  EXPECT_GE(found, 96);
}

TEST(PnpTest, FindsThePoseBeforeAPlane) {
  Deviation worst;
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    Dice dice(seed);
    const Camera camera = arenaCamera();
    const common::Pose3 T = dice.pose(4.0, 3.0);
    auto observations = observe(camera, T, 100, 0, dice);
    const Eigen::Vector3d normal = Eigen::Vector3d(dice.uniform(-0.5, 0.5), dice.uniform(-0.5, 0.5), 1.0);
    for (std::size_t i = 0; i < observations.size(); ++i) {
      const Eigen::Vector2d pixel = dice.pixel(camera);
      const Eigen::Vector3d bearing = camera.unproject(pixel);
      observations[i].p_mono_point = T.inverse() * (3.0 / normal.dot(bearing) * bearing);
      observations[i].pixel = i < 40 ? dice.pixel(camera) : Eigen::Vector2d(pixel + dice.noise(1.0));
    }
    const auto optimum = solvePnp(camera, observations, {});
    ASSERT_TRUE(optimum) << seed;
    worst.add(optimum->T_camera_mono, T);
  }
  EXPECT_LT(worst.position, 0.08);
  EXPECT_LT(worst.angle, 0.03);
}

TEST(PnpTest, OutliersAloneGiveNothing) {
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    Dice dice(seed);
    const Camera camera = seed % 2 == 0 ? arenaCamera() : fisheyeCamera();
    EXPECT_FALSE(solvePnp(camera, observe(camera, dice.pose(4.0, 3.0), 200, 200, dice), {})) << seed;
  }
}

TEST(PnpTest, TooFewOrDegenerateObservationsGiveNothing) {
  Dice dice(5);
  const Camera camera = arenaCamera();
  const common::Pose3 T = dice.pose(4.0, 3.0);
  EXPECT_FALSE(solvePnp(camera, {}, {}));
  EXPECT_FALSE(solvePnp(camera, observe(camera, T, 14, 0, dice), {}));
  auto line = observe(camera, T, 100, 0, dice);
  for (std::size_t i = 0; i < line.size(); ++i) {
    const Eigen::Vector3d p(0.01 * static_cast<double>(i), 0.0, 3.0);
    line[i] = {T.inverse() * p, *camera.project(p), 1.0};
  }
  EXPECT_FALSE(solvePnp(camera, line, {}));
}

TEST(PnpTest, SameSeedSamePose) {
  Dice dice(6);
  const common::Pose3 T = dice.pose(4.0, 3.0);
  const auto observations = observe(arenaCamera(), T, 150, 75, dice);
  const auto first = solvePnp(arenaCamera(), observations, {});
  const auto second = solvePnp(arenaCamera(), observations, {});
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->T_camera_mono.matrix(), second->T_camera_mono.matrix());
  EXPECT_EQ(first->inliers, second->inliers);
}

}  // namespace
}  // namespace rubble::slam_mono
