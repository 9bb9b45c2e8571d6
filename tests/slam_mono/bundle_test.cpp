#include "mapping/bundle.h"

#include <gmock/gmock.h>

#include <random>
#include <set>

#include "geometry/pose_optimizer.h"
#include "loop/correction.h"
#include "loop/pose_graph.h"
#include "synthetic_mission.h"
#include "synthetic_scenes.h"

namespace rubble::slam_mono {
namespace {

const Camera kCamera({.distortion = {-0.22, 0.045, 0.0006, -0.0004}});

common::Pose3 cameraAt(double x) {
  common::Pose3 T = common::Pose3::Identity();
  T.linear() = Eigen::AngleAxisd(0.05 * x, Eigen::Vector3d::UnitY()).toRotationMatrix();
  T.translation().x() = -x;
  return T;
}

/// By number of keyframes, which decides how the linear system is solved.
class BundleSolverTest : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Keyframes, BundleSolverTest, testing::Values(5, 80, 420));

TEST_P(BundleSolverTest, FindsBackToExactDataAndNamesTheOutlier) {
  const int keyframes = GetParam();
  const bool sparse = keyframes > 100;  // One keyframe of five sees a point.
  std::mt19937_64 random(1);
  const auto noise = [&](double size) {
    return size * (2.0 * static_cast<double>(random() >> 11) * 0x1p-53 - 1.0);
  };
  BundleProblem problem;
  std::vector<common::Pose3> truth;
  for (int k = 0; k < keyframes; ++k) {
    truth.push_back(cameraAt(1.5 * k / keyframes));
    const bool fixed = k < 2 || (sparse && k == keyframes / 2);
    problem.keyframes.push_back(k);
    problem.fixed.push_back(fixed);
    Eigen::Matrix<double, 6, 1> delta = Eigen::Matrix<double, 6, 1>::Zero();
    if (!fixed) {
      for (int i = 0; i < 6; ++i) {
        delta[i] = noise(0.02);
      }
    }
    problem.T_camera_mono.push_back(perturbed(truth.back(), delta));
  }
  std::vector<Eigen::Vector3d> points;
  for (std::size_t i = 0; i < 60; ++i) {
    points.emplace_back(noise(1.5), noise(1.0), 4.0 + noise(1.0));
    problem.points.push_back(static_cast<PointId>(i));
    problem.p_mono_point.push_back(points.back() + Eigen::Vector3d(noise(0.1), noise(0.1), noise(0.1)));
    for (std::size_t k = 0; k < truth.size(); ++k) {
      if (sparse && random() % 5 != 0) {
        continue;
      }
      const auto pixel = kCamera.project(truth[k] * points.back());
      ASSERT_TRUE(pixel);
      problem.residuals.push_back({k, i, {static_cast<KeyframeId>(k), 0}, *pixel, 1.0});
    }
  }
  problem.residuals[17].pixel.x() += 40.0;
  solveBundle(kCamera, problem, {.iterations = 50, .tolerance = 1e-12});
  EXPECT_THAT(problem.outliers, testing::ElementsAre(17U));
  for (std::size_t k = 0; k < truth.size(); ++k) {
    // The outlier pulls at its keyframe, the more the fewer points that one sees.
    const double limit = sparse && k == problem.residuals[17].keyframe ? 0.05 : 0.01;
    EXPECT_LT((problem.T_camera_mono[k].matrix() - truth[k].matrix()).norm(), limit) << k;
  }
  for (std::size_t i = 10; i < points.size(); ++i) {
    EXPECT_LT((problem.p_mono_point[i] - points[i]).norm(), 0.02) << i;
  }
}

TEST(BundleTest, OfALargeMapTheLongestTracksAreAdjustedAndTheRestFollows) {
  const SyntheticScene scene = makeRoom(1);
  const FloorPath path(scene.line, scene.closed, 0.8);
  Route route(path.at(0.0), 15.0, 1);
  route.drive(path, 0.0, 4.0, 0.5);
  const MonoSlamConfig config;
  Mission mission(scene.world, arenaCamera(), config, 1);
  mission.follow(route.poses());
  const OctaveScales scales(config.orb.scale_factor, config.orb.levels, arenaCamera().pixelAngle());
  const Map& before = *mission.map();
  const int map_id = before.mapIds().front();
  const BundleProblem all = makeFullBundle(before, map_id, scales);
  const std::size_t most = all.residuals.size() / 4;
  BundleProblem problem = makeFullBundle(before, map_id, scales, most);
  EXPECT_LT(problem.residuals.size(), 2 * most);
  std::vector<std::size_t> residuals(problem.keyframes.size(), 0);
  for (const BundleProblem::Residual& r : problem.residuals) {
    ++residuals[r.keyframe];
  }
  EXPECT_THAT(residuals, testing::Each(testing::Ge(std::size_t{20})));

  solveBundle(arenaCamera(), problem, kFullEffort);
  Map after = before;
  applyFullBundle(after, before, problem, scales);
  const std::set<PointId> solved(problem.points.begin(), problem.points.end());
  for (const PointId id : after.points()) {
    const MapPoint& point = *after.point(id);
    if (!solved.contains(id) && point.reference == before.point(id)->reference) {
      const auto seenFrom = [&](const Map& map) -> Eigen::Vector3d {
        return map.keyframe(point.reference)->T_camera_mono * map.point(id)->p_mono_point;
      };
      EXPECT_LT((seenFrom(after) - seenFrom(before)).norm(), 1e-6) << id;
    }
  }
}

TEST(PoseGraphTest, SpreadsALoopsErrorIncludingScale) {
  // A chain around a square whose steps are measured with a scale that drifts, closed by one exact edge.
  constexpr std::size_t kCount = 20;
  constexpr double kDrift = 1.02;
  std::vector<Sim3> truth;
  for (std::size_t i = 0; i < kCount; ++i) {
    const double angle = 2.0 * 3.14159265358979 * static_cast<double>(i) / kCount;
    const Sim3 S_mono_camera(Eigen::Quaterniond(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ())),
                             {3.0 * std::cos(angle), 3.0 * std::sin(angle), 0.0}, 1.0);
    truth.push_back(S_mono_camera.inverse());
  }
  std::vector<PoseGraphEdge> edges;
  std::vector<Sim3> start{truth[0]};
  for (std::size_t i = 1; i < kCount; ++i) {
    Sim3 S_b_a = truth[i] * truth[i - 1].inverse();
    S_b_a.scale *= kDrift;
    edges.push_back({i, i - 1, S_b_a});
    start.push_back(S_b_a * start.back());
  }
  edges.push_back({0, kCount - 1, truth[0] * truth[kCount - 1].inverse()});
  const auto gap = [&](const std::vector<Sim3>& S) {
    return (S[kCount - 1].inverse().translation - truth[kCount - 1].inverse().translation).norm();
  };
  std::vector<Sim3> solved = start;
  optimizePoseGraph(solved, edges, 0);
  EXPECT_GT(gap(start), 0.5);
  EXPECT_LT(gap(solved), 0.1 * gap(start));
  EXPECT_EQ(solved[0].translation, truth[0].translation);
  for (const Sim3& S : solved) {
    EXPECT_NEAR(S.scale, 1.0, 0.25);
  }
}

}  // namespace
}  // namespace rubble::slam_mono
