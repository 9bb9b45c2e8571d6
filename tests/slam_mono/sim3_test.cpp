#include "geometry/sim3.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "geometry_scene.h"

namespace rubble::slam_mono {
namespace {

Sim3 randomSimilarity(Dice& dice, double extent, double angle) {
  return Sim3(dice.pose(extent, angle), std::exp(dice.uniform(-0.7, 0.7)));
}

/// Points that both of two near cameras see; the second map has its own scale. 1 % of depth error in each
/// map.
std::vector<PointPair> observe(const Camera& camera, const Sim3& S_a_b, int count, int outliers, double noise,
                               double depth_noise, Dice& dice) {
  std::vector<PointPair> pairs;
  while (static_cast<int>(pairs.size()) < count) {
    const bool outlier = static_cast<int>(pairs.size()) < outliers;
    const Eigen::Vector3d p_a = dice.uniform(1.0, 8.0) * camera.unproject(dice.pixel(camera));
    const Eigen::Vector3d p_b =
        outlier ? Eigen::Vector3d(dice.uniform(1.0, 8.0) * camera.unproject(dice.pixel(camera)))
                : S_a_b.inverse() * p_a;
    const auto pixel_a = camera.project(p_a);
    const auto pixel_b = camera.project(p_b);
    if (pixel_a && pixel_b && camera.contains(*pixel_b)) {
      pairs.push_back({p_a * (1.0 + dice.normal(depth_noise)), p_b * (1.0 + dice.normal(depth_noise)),
                       *pixel_a + dice.noise(noise), *pixel_b + dice.noise(noise), 1.0, 1.0});
    }
  }
  return pairs;
}

struct Deviation {
  double translation = 0.0;
  double angle = 0.0;
  double scale = 0.0;

  void add(const Sim3& found, const Sim3& S) {
    translation = std::max(translation, (found.translation - S.translation).norm());
    angle = std::max(angle, found.rotation.angularDistance(S.rotation));
    scale = std::max(scale, std::abs(std::log(found.scale / S.scale)));
  }
};

TEST(Sim3Test, IsAGroup) {
  Dice dice(1);
  for (int i = 0; i < 100; ++i) {
    const Sim3 A = randomSimilarity(dice, 3.0, 3.0);
    const Sim3 B = randomSimilarity(dice, 3.0, 3.0);
    const Eigen::Vector3d p = dice.vector(4.0);
    EXPECT_LT(((A * B) * p - A * (B * p)).norm(), 1e-12);
    EXPECT_LT((A.inverse() * (A * p) - p).norm(), 1e-12);
    EXPECT_LT((A * A.inverse() * p - p).norm(), 1e-12);
    EXPECT_LT(((A * B).inverse() * p - B.inverse() * (A.inverse() * p)).norm(), 1e-12);
    EXPECT_LT((Sim3() * p - p).norm(), 1e-15);
    const common::Pose3 T = dice.pose(2.0, 2.0);
    EXPECT_LT((Sim3(T, 1.0) * p - T * p).norm(), 1e-12);
  }
}

TEST(Sim3Test, NormalizedKeepsThePicture) {
  // A point of the map scaled by 1 / s seen from the pose scaled alike falls on the same pixel.
  Dice dice(2);
  const Sim3 S = randomSimilarity(dice, 3.0, 3.0);
  const Eigen::Vector3d p = dice.vector(4.0);
  EXPECT_LT((S.scale * (S.normalized() * p) - S * p).norm(), 1e-12);
}

TEST(Sim3Test, ExactDataGiveTheExactSimilarity) {
  for (const Camera& camera : {arenaCamera(), fisheyeCamera()}) {
    Deviation worst;
    for (std::uint64_t seed = 1; seed <= 30; ++seed) {
      Dice dice(seed);
      const Sim3 S = randomSimilarity(dice, 0.5, 0.3);
      const auto result = solveSim3(camera, observe(camera, S, 50, 0, 0.0, 0.0, dice), {});
      ASSERT_TRUE(result);
      EXPECT_EQ(result->inlier_count, 50);
      worst.add(result->S_a_b, S);
    }
    EXPECT_LT(worst.translation, 1e-6);
    EXPECT_LT(worst.angle, 1e-6);
    EXPECT_LT(worst.scale, 1e-6);
  }
}

TEST(Sim3Test, FindsTheSimilarityBetweenHalfOutliers) {
  for (const Camera& camera : {arenaCamera(), fisheyeCamera()}) {
    Deviation worst;
    for (std::uint64_t seed = 1; seed <= 100; ++seed) {
      Dice dice(seed);
      const Sim3 S = randomSimilarity(dice, 0.5, 0.3);
      const auto pairs = observe(camera, S, 100, 50, 1.0, 0.01, dice);
      Sim3Config config;
      config.seed = seed;
      const auto result = solveSim3(camera, pairs, config);
      ASSERT_TRUE(result) << seed;
      EXPECT_GT(result->inlier_count, 40) << seed;
      EXPECT_LE(std::count(result->inliers.begin(), result->inliers.begin() + 50, true), 3) << seed;
      EXPECT_EQ(std::count(result->inliers.begin(), result->inliers.end(), true), result->inlier_count);
      worst.add(result->S_a_b, S);
    }
    EXPECT_LT(worst.translation, 0.1);
    EXPECT_LT(worst.angle, 0.02);
    EXPECT_LT(worst.scale, 0.05);
  }
}

TEST(Sim3Test, RefinementConvergesFromAside) {
  Deviation worst;
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    Dice dice(seed);
    const Camera camera = arenaCamera();
    const Sim3 S = randomSimilarity(dice, 0.5, 0.3);
    const auto pairs = observe(camera, S, 80, 16, 1.0, 0.0, dice);
    const Sim3 start = Sim3(dice.pose(0.2, 0.1), 1.2) * S;
    const Sim3Result result = refineSim3(camera, pairs, start, 3.0);
    EXPECT_GT(result.inlier_count, 55) << seed;
    worst.add(result.S_a_b, S);
  }
  EXPECT_LT(worst.translation, 0.06);
  EXPECT_LT(worst.angle, 0.02);
  EXPECT_LT(worst.scale, 0.02);
}

TEST(Sim3Test, ScaleStaysWhereNoParallaxTellsIt) {
  // Both keyframes at one place: the pictures agree at any scale, only the maps' depths differ.
  Deviation worst;
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    Dice dice(seed);
    const Camera camera = arenaCamera();
    const Sim3 S = randomSimilarity(dice, 1e-9, 0.2);
    const auto result = solveSim3(camera, observe(camera, S, 80, 20, 1.0, 0.03, dice), {});
    ASSERT_TRUE(result) << seed;
    worst.add(result->S_a_b, S);
  }
  EXPECT_LT(worst.scale, 0.03);
  EXPECT_LT(worst.angle, 0.01);
}

TEST(Sim3Test, OutliersAloneGiveNothing) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    Dice dice(seed);
    EXPECT_FALSE(solveSim3(arenaCamera(), observe(arenaCamera(), Sim3(), 100, 100, 1.0, 0.0, dice), {}));
  }
}

TEST(Sim3Test, APlaneSufficesALineDoesNot) {
  Dice dice(3);
  const Camera camera = arenaCamera();
  const Sim3 S = randomSimilarity(dice, 0.3, 0.2);
  std::vector<PointPair> plane;
  std::vector<PointPair> line;
  for (int i = 0; i < 60; ++i) {
    for (auto* pairs : {&plane, &line}) {
      const double y = pairs == &plane ? dice.uniform(-0.5, 0.5) : 0.1;
      const Eigen::Vector3d p_a(dice.uniform(-0.8, 0.8), y, 3.0);
      const Eigen::Vector3d p_b = S.inverse() * p_a;
      pairs->push_back({p_a, p_b, *camera.project(p_a), *camera.project(p_b), 1.0, 1.0});
    }
  }
  const auto result = solveSim3(camera, plane, {});
  ASSERT_TRUE(result);
  EXPECT_NEAR(result->S_a_b.scale, S.scale, 1e-6);
  EXPECT_FALSE(solveSim3(camera, line, {}));
  EXPECT_FALSE(solveSim3(camera, {}, {}));
  EXPECT_FALSE(solveSim3(camera, std::span(plane).first(19), {}));
  EXPECT_EQ(refineSim3(camera, {}, S, 3.0).inlier_count, 0);
}

}  // namespace
}  // namespace rubble::slam_mono
