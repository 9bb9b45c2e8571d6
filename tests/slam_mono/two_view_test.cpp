#include "geometry/two_view.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include "geometry_scene.h"

namespace rubble::slam_mono {
namespace {

/// Depth of what is seen in a direction from camera a.
using Scene = std::function<double(const Eigen::Vector3d& bearing, Dice& dice)>;

double boxes(const Eigen::Vector3d& /*bearing*/, Dice& dice) { return dice.uniform(2.0, 7.0); }
/// A floor 0.5 under the camera that climbs away from it.
double slope(const Eigen::Vector3d& bearing, Dice& /*dice*/) {
  return 1.0 / std::max(1e-3, Eigen::Vector3d(0.1, 0.35, 0.3).dot(bearing));
}
double wall(const Eigen::Vector3d& bearing, Dice& /*dice*/) { return 3.0 / std::max(1e-3, bearing.z()); }
/// A wall with something before it here and there.
double furnishedWall(const Eigen::Vector3d& bearing, Dice& dice) {
  return wall(bearing, dice) * (dice.chance(0.25) ? dice.uniform(0.4, 0.8) : 1.0);
}

struct Case {
  common::Pose3 T_b_a;
  Scene scene = boxes;
  int count = 300;
  double outlier_share = 0.3;
  double noise = 1.0;
};

std::vector<TwoViewMatch> match(const Camera& camera, const Case& test, Dice& dice) {
  std::vector<TwoViewMatch> matches;
  while (static_cast<int>(matches.size()) < test.count) {
    const double sigma = std::pow(1.2, dice.uniform(0.0, 4.0));
    const Eigen::Vector2d pixel_a = dice.pixel(camera);
    if (dice.chance(test.outlier_share)) {
      matches.push_back({pixel_a, dice.pixel(camera), sigma});
      continue;
    }
    const Eigen::Vector3d bearing = camera.unproject(pixel_a);
    const double depth = test.scene(bearing, dice);
    const auto pixel_b = camera.project(test.T_b_a * (depth * bearing));
    if (depth < 30.0 && pixel_b && camera.contains(*pixel_b)) {
      matches.push_back(
          {pixel_a + dice.noise(test.noise * sigma), *pixel_b + dice.noise(test.noise * sigma), sigma});
    }
  }
  return matches;
}

struct Tally {
  int found = 0;
  int wrong = 0;  ///< of the found: more than 0.15 rad off
  int planar = 0;
  double worst_direction = 0.0;
  double worst_rotation = 0.0;
};

Tally run(const Camera& camera, const Case& test, int seeds, std::uint64_t first_seed = 1) {
  Tally tally;
  for (int i = 0; i < seeds; ++i) {
    Dice dice(first_seed + static_cast<std::uint64_t>(i));
    TwoViewConfig config;
    config.seed = first_seed + static_cast<std::uint64_t>(i);
    const auto matches = match(camera, test, dice);
    const auto result = reconstructTwoViews(camera, matches, config);
    if (!result) {
      continue;
    }
    ++tally.found;
    EXPECT_NEAR(result->T_b_a.translation().norm(), 1.0, 1e-9);
    EXPECT_EQ(result->points_a.size(), matches.size());
    EXPECT_EQ(std::count_if(result->points_a.begin(), result->points_a.end(),
                            [](const auto& point) { return point.has_value(); }),
              result->point_count);
    EXPECT_GE(result->parallax, config.min_parallax);
    const double direction = angleBetween(result->T_b_a.translation(), test.T_b_a.translation());
    const double rotation = rotationError(result->T_b_a, test.T_b_a);
    tally.worst_direction = std::max(tally.worst_direction, direction);
    tally.worst_rotation = std::max(tally.worst_rotation, rotation);
    tally.wrong += direction > 0.15 || rotation > 0.15 ? 1 : 0;
    tally.planar += result->planar ? 1 : 0;
  }
  return tally;
}

common::Pose3 seenFrom(const Eigen::Vector3d& p_a_b, const Eigen::Vector3d& turn) {
  return Dice::rigid(p_a_b, turn).inverse();
}

TEST(TwoViewTest, TriangulatesWhereTheBearingsMeet) {
  Dice dice(1);
  for (int i = 0; i < 100; ++i) {
    const common::Pose3 T_b_a = dice.pose(1.0, 2.0);
    const Eigen::Vector3d p = dice.vector(5.0);
    const auto found = triangulate(T_b_a, p.normalized(), (T_b_a * p).normalized());
    ASSERT_TRUE(found);
    EXPECT_LT((*found - p).norm(), 1e-7 * (1.0 + p.squaredNorm()));
  }
  const common::Pose3 aside = seenFrom({1.0, 0.0, 0.0}, Eigen::Vector3d::Zero());
  EXPECT_FALSE(triangulate(aside, Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitZ()));
  // They meet behind both.
  EXPECT_FALSE(triangulate(aside, Eigen::Vector3d(-0.1, 0.0, 1.0).normalized(), Eigen::Vector3d::UnitZ()));
  // Skew bearings: the point lies between them.
  const auto skew = triangulate(aside, Eigen::Vector3d(0.2, 0.01, 1.0).normalized(),
                                Eigen::Vector3d(-0.2, -0.01, 1.0).normalized());
  ASSERT_TRUE(skew);
  EXPECT_LT((*skew - Eigen::Vector3d(0.5, 0.0, 2.5)).norm(), 0.01);
}

TEST(TwoViewTest, SidewaysBeforeBoxes) {
  for (const Camera& camera : {arenaCamera(), fisheyeCamera()}) {
    const Tally tally = run(camera, {seenFrom({0.4, 0.05, 0.0}, {0.02, -0.05, 0.03})}, 60);
    EXPECT_GE(tally.found, 58);
    EXPECT_EQ(tally.wrong, 0);
    EXPECT_LT(tally.worst_rotation, 0.02);
    EXPECT_EQ(tally.planar, 0);
  }
}

TEST(TwoViewTest, ForwardsBetweenBoxes) {
  for (const Camera& camera : {arenaCamera(), fisheyeCamera()}) {
    const Tally tally = run(camera, {seenFrom({0.05, 0.0, 0.7}, {0.02, 0.04, 0.0})}, 60);
    EXPECT_GE(tally.found, 56);
    EXPECT_EQ(tally.wrong, 0);
    EXPECT_LT(tally.worst_direction, 0.1);
    EXPECT_LT(tally.worst_rotation, 0.03);
  }
}

TEST(TwoViewTest, SidewaysOverASlope) {
  const Tally tally = run(arenaCamera(), {seenFrom({0.4, 0.0, 0.1}, {0.0, 0.05, 0.02}), slope}, 60);
  EXPECT_GE(tally.found, 40);
  EXPECT_EQ(tally.wrong, 0);
  EXPECT_GE(tally.planar, tally.found - 3);
}

TEST(TwoViewTest, SidewaysBeforeAWall) {
  const Tally tally = run(arenaCamera(), {seenFrom({0.5, 0.0, 0.0}, {0.0, -0.1, 0.0}), wall}, 60);
  EXPECT_GE(tally.found, 40);
  EXPECT_EQ(tally.wrong, 0);
}

TEST(TwoViewTest, ForwardsToAWallIsRightOrRefused) {
  for (const Eigen::Vector3d& way : {Eigen::Vector3d(0.0, 0.0, 0.8), Eigen::Vector3d(0.4, 0.0, 0.6)}) {
    EXPECT_EQ(run(arenaCamera(), {seenFrom(way, {0.02, 0.03, 0.0}), wall}, 60).wrong, 0);
  }
}

TEST(TwoViewTest, ForwardsToAFurnishedWall) {
  // Before the wall alone both motions of its homography meet: what stands before it tells the direction.
  for (const double outliers : {0.05, 0.2, 0.4}) {
    Case test{seenFrom({0.02, 0.0, 0.6}, {0.02, 0.03, 0.0}), furnishedWall};
    test.outlier_share = outliers;
    const Tally tally = run(arenaCamera(), test, 60);
    EXPECT_EQ(tally.wrong, 0) << outliers << " found " << tally.found;
    EXPECT_LT(tally.worst_direction, 0.1) << outliers << " found " << tally.found;
    if (outliers < 0.1) {
      EXPECT_GE(tally.found, 55);
    }
  }
}

TEST(TwoViewTest, ATurnIsNeverAStart) {
  struct Turn {
    double angle, outlier_share, noise;
  };
  for (const Camera& camera : {arenaCamera(), fisheyeCamera()}) {
    for (const Turn& turn :
         {Turn{0.02, 0.0, 1.0}, Turn{0.02, 0.3, 1.0}, Turn{0.1, 0.3, 0.5}, Turn{0.1, 0.3, 1.5},
          Turn{0.3, 0.0, 1.0}, Turn{0.3, 0.3, 1.0}, Turn{0.3, 0.45, 1.0}}) {
      Case test{Dice::rigid(Eigen::Vector3d::Zero(), {0.1 * turn.angle, turn.angle, 0.1 * turn.angle})};
      test.outlier_share = turn.outlier_share;
      test.noise = turn.noise;
      EXPECT_EQ(run(camera, test, 100).found, 0)
          << turn.angle << " " << turn.outlier_share << " " << turn.noise;
    }
  }
}

TEST(TwoViewTest, AHandsBreadthInATurnIsRightOrRefused) {
  // Parallax of a few pixels only: 1 to 10 cm aside of boxes 2 to 7 m away.
  for (const double aside : {0.01, 0.03, 0.06, 0.1}) {
    EXPECT_EQ(run(arenaCamera(), {seenFrom({aside, 0.0, 0.0}, {0.0, 0.15, 0.0})}, 60).wrong, 0) << aside;
  }
}

TEST(TwoViewTest, StandingStillIsNeverAStart) {
  for (const Camera& camera : {arenaCamera(), fisheyeCamera()}) {
    for (const double outliers : {0.0, 0.3}) {
      Case test{common::Pose3::Identity()};
      test.outlier_share = outliers;
      EXPECT_EQ(run(camera, test, 100).found, 0);
    }
  }
}

TEST(TwoViewTest, TooLittleParallaxIsRefused) {
  // 5 cm before boxes 2 to 7 m away: 0.011 rad.
  const Tally tally = run(arenaCamera(), {seenFrom({0.05, 0.0, 0.0}, {0.0, 0.05, 0.0})}, 60);
  EXPECT_EQ(tally.found, 0);
}

TEST(TwoViewTest, MatchesWithoutASceneAreRefused) {
  Case test{common::Pose3::Identity()};
  test.outlier_share = 1.0;
  EXPECT_EQ(run(arenaCamera(), test, 30).found, 0);
}

TEST(TwoViewTest, TooFewMatchesAreRefused) {
  const Camera camera = arenaCamera();
  EXPECT_FALSE(reconstructTwoViews(camera, {}, {}));
  Case test{seenFrom({0.4, 0.0, 0.0}, {0.0, 0.05, 0.0})};
  test.count = 49;
  test.outlier_share = 0.0;
  EXPECT_EQ(run(camera, test, 5).found, 0);
}

TEST(TwoViewTest, PointsLieWhereTheyAre) {
  const Camera camera = arenaCamera();
  Case test{seenFrom({0.5, 0.0, 0.0}, {0.0, -0.05, 0.0})};
  test.outlier_share = 0.0;
  test.noise = 0.0;
  Dice dice(9);
  const auto matches = match(camera, test, dice);
  const auto result = reconstructTwoViews(camera, matches, {});
  ASSERT_TRUE(result);
  EXPECT_EQ(result->point_count, 300);
  EXPECT_LT(angleBetween(result->T_b_a.translation(), test.T_b_a.translation()), 1e-5);
  EXPECT_LT(rotationError(result->T_b_a, test.T_b_a), 1e-5);
  for (const auto& point : result->points_a) {
    ASSERT_TRUE(point);
    EXPECT_GT(0.5 * point->norm(), 1.99);
    EXPECT_LT(0.5 * point->norm(), 7.01);
  }
}

TEST(TwoViewTest, SameSeedSameResult) {
  Dice dice(10);
  const auto matches = match(arenaCamera(), {seenFrom({0.4, 0.0, 0.0}, {0.0, 0.05, 0.0})}, dice);
  const auto first = reconstructTwoViews(arenaCamera(), matches, {});
  const auto second = reconstructTwoViews(arenaCamera(), matches, {});
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->T_b_a.matrix(), second->T_b_a.matrix());
}

}  // namespace
}  // namespace rubble::slam_mono
