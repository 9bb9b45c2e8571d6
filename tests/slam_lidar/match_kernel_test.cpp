#include "match_kernel.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "gauss_newton.h"
#include "grid_map.h"

namespace rubble::slam_lidar {
namespace {

class MatchKernel : public testing::TestWithParam<Eigen::Vector2d> {
 protected:
  MatchKernel() : map_(GridSlamConfig{}), T_(GetParam().x(), GetParam().y(), 0.4) {
    std::mt19937 random(3);
    std::uniform_real_distribution<float> coordinate(-8.0F, 8.0F);
    std::vector<RayEnd> rays;
    for (int i = 0; i < 2000; ++i) {
      rays.push_back({coordinate(random), coordinate(random), true});
    }
    map_.write(T_, rays);
    for (int i = 0; i < 357; ++i) {
      points_.add(coordinate(random), coordinate(random), 0.5F + 0.001F * static_cast<float>(i));
    }
    points_.add(500.0F, -700.0F, 1.0F);  // far outside the window: unknown
    points_.pad();
  }

  GridMap map_;
  PointSet points_;
  common::Pose2 T_;
};

TEST_P(MatchKernel, EqualsTheScalarOracle) {
  for (const TiledGrid& level : map_.levels()) {
    const MatchSums fast = linearise(level.view(), points_, T_);
    const MatchSums slow = lineariseScalar(level.view(), points_, T_);
    EXPECT_LT((fast.H - slow.H).norm(), 2e-3 * slow.H.norm());
    EXPECT_LT((fast.g - slow.g).norm(), 2e-3 * std::sqrt(slow.H.trace() * slow.cost))
        << "terms cancel in the sum";
    EXPECT_NEAR(fast.agree, slow.agree, 2e-3 * slow.agree);
    EXPECT_NEAR(fast.contradict, slow.contradict, 2e-3 * slow.contradict);
    EXPECT_NEAR(fast.cost, slow.cost, 2e-3 * slow.cost);
    const MatchSums scores = evaluate(level.view(), points_, T_);
    EXPECT_DOUBLE_EQ(scores.agree, fast.agree);
    EXPECT_DOUBLE_EQ(scores.contradict, fast.contradict);
  }
}

/// g = -1/2 d cost / d pose: bilinear interpolation, its gradient and the pose's Jacobian in one.
TEST_P(MatchKernel, GradientEqualsTheNumericOne) {
  const GridView view = map_.finest().view();
  // Single points, so that none lies on a cell's border, where the gradient jumps.
  int compared = 0;
  for (std::size_t i = 0; i < 100; ++i) {
    PointSet one;
    one.add(points_.x()[i], points_.y()[i], 1.0F);
    one.pad();
    const Eigen::Vector3d g = lineariseScalar(view, one, T_).g;
    Eigen::Vector3d numeric;
    Eigen::Vector3d one_sided;
    const double h = 1e-6;
    const double here = lineariseScalar(view, one, T_).cost;
    for (int k = 0; k < 3; ++k) {
      const auto moved = [&](double by) {
        return common::Pose2{T_.x + (k == 0 ? by : 0.0), T_.y + (k == 1 ? by : 0.0),
                             T_.yaw + (k == 2 ? by : 0.0)};
      };
      const double plus = lineariseScalar(view, one, moved(h)).cost;
      const double minus = lineariseScalar(view, one, moved(-h)).cost;
      numeric[k] = -0.5 * (plus - minus) / (2.0 * h);
      one_sided[k] = -0.5 * (plus - here) / h;
    }
    if ((numeric - one_sided).norm() < 1e-2) {
      EXPECT_LT((g - numeric).norm(), 1e-4 * (1.0 + numeric.norm())) << i;
      ++compared;
    }
  }
  EXPECT_GT(compared, 80);
}

INSTANTIATE_TEST_SUITE_P(NearAndFar, MatchKernel,
                         testing::Values(Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(-10000.0, 10000.0)));

}  // namespace
}  // namespace rubble::slam_lidar
