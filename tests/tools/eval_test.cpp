#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <random>

#include "eval_ate.h"
#include "eval_consistency.h"
#include "eval_crossings.h"
#include "eval_map.h"
#include "eval_relations.h"
#include "map_file.h"
#include "support/error_text.h"
#include "support/temp_dir.h"

namespace rubble::tools {
namespace {

using common::Pose3;
using common::Trajectory;
using test::errorOf;
using ::testing::HasSubstr;

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr common::Utime kStep = 50'000;

Pose3 makePose(double x, double y, double z, double roll, double pitch, double yaw) {
  Pose3 T = Pose3::Identity();
  T.linear() = common::rotationFromRpy({roll, pitch, yaw});
  T.translation() = Eigen::Vector3d(x, y, z);
  return T;
}

/// A path in all directions, 20 Hz.
Trajectory helix(int n) {
  Trajectory trajectory;
  for (int i = 0; i < n; ++i) {
    const double t = 0.05 * i;
    trajectory.push_back({i * kStep, makePose(std::cos(t), std::sin(2 * t), 0.3 * t, 0.1 * std::sin(t),
                                              0.2 * std::cos(t), 0.5 * t)});
  }
  return trajectory;
}

Trajectory moved(const Trajectory& trajectory, const Pose3& T, double scale) {
  Trajectory out = trajectory;
  for (common::StampedPose& pose : out) {
    pose.T_a_b.translation() *= scale;
    pose.T_a_b = T * pose.T_a_b;
  }
  return out;
}

Trajectory noisy(Trajectory trajectory) {
  std::mt19937 generator(7);
  std::normal_distribution<double> noise(0.0, 0.02);
  for (common::StampedPose& pose : trajectory) {
    pose.T_a_b.translation() += Eigen::Vector3d(noise(generator), noise(generator), noise(generator));
    pose.T_a_b.rotate(Eigen::AngleAxisd(noise(generator), Eigen::Vector3d::UnitX()));
  }
  return trajectory;
}

struct Group {
  Alignment alignment;
  Pose3 T;
  double scale;
};

class AteGroupTest : public ::testing::TestWithParam<int> {
 protected:
  /// A transform that the alignment can undo.
  static Group group(int index) {
    const Pose3 any = makePose(3.0, -4.0, 5.0, 0.7, -0.4, 2.0);
    const std::vector<Group> groups = {{Alignment::kSim3, any, 2.5},
                                       {Alignment::kSe3, any, 1.0},
                                       {Alignment::kStart, makePose(3.0, -4.0, 5.0, 0.0, 0.0, 2.0), 1.0}};
    return groups[static_cast<std::size_t>(index)];
  }
};

TEST_P(AteGroupTest, ExactUpToTheGroupIsZero) {
  const Group g = group(GetParam());
  const Trajectory truth = helix(100);
  const AteResult result = evaluateAte(moved(truth, g.T, g.scale), truth, g.alignment, 0.1);
  EXPECT_EQ(result.matched, 100);
  EXPECT_NEAR(result.translation_m.max, 0.0, 1e-9);
  EXPECT_NEAR(result.z_rmse_m, 0.0, 1e-9);
  EXPECT_NEAR(result.attitude_rmse_deg, 0.0, 1e-6);
  EXPECT_NEAR(result.rotation_rmse_deg, 0.0, 1e-6);
  EXPECT_NEAR(result.scale, 1.0 / g.scale, 1e-9);
  EXPECT_DOUBLE_EQ(result.tracked_share, 1.0);
}

TEST_P(AteGroupTest, InvariantUnderTheGroup) {
  const Group g = group(GetParam());
  const Trajectory truth = helix(100);
  const Trajectory estimate = noisy(truth);
  const AteResult a = evaluateAte(estimate, truth, g.alignment, 0.1);
  const AteResult b = evaluateAte(moved(estimate, g.T, g.scale), truth, g.alignment, 0.1);
  EXPECT_GT(a.translation_m.rmse, 0.01);
  EXPECT_NEAR(a.translation_m.rmse, b.translation_m.rmse, 1e-9);
  EXPECT_NEAR(a.z_rmse_m, b.z_rmse_m, 1e-9);
  EXPECT_NEAR(a.attitude_rmse_deg, b.attitude_rmse_deg, 1e-6);
  EXPECT_NEAR(a.rotation_rmse_deg, b.rotation_rmse_deg, 1e-6);
}

INSTANTIATE_TEST_SUITE_P(All, AteGroupTest, ::testing::Values(0, 1, 2));

TEST(AteTest, StartNeverTakesRollOrPitchAway) {
  const Trajectory truth = helix(50);
  const AteResult result =
      evaluateAte(moved(truth, makePose(0, 0, 0, 5 * kDegree, 0, 1.0), 1.0), truth, Alignment::kStart, 0.1);
  EXPECT_NEAR(result.attitude_rmse_deg, 5.0, 1e-6);
}

TEST(AteTest, ErrorsByHand) {
  Trajectory truth;
  Trajectory estimate;
  for (int i = 0; i < 4; ++i) {
    truth.push_back({i * kStep, makePose(i, 0, 0, 0, 0, 0)});
    estimate.push_back({i * kStep, makePose(i, 0, i == 3 ? 2.0 : 0.0, 0, 0, i == 3 ? 0.1 : 0.0)});
  }
  const AteResult result = evaluateAte(estimate, truth, Alignment::kStart, 0.1);
  EXPECT_NEAR(result.translation_m.rmse, 1.0, 1e-12);
  EXPECT_NEAR(result.translation_m.mean, 0.5, 1e-12);
  EXPECT_NEAR(result.z_rmse_m, 1.0, 1e-12);
  EXPECT_NEAR(result.attitude_rmse_deg, 0.0, 1e-9);
  EXPECT_NEAR(result.rotation_rmse_deg, 0.05 / kDegree, 1e-6);
}

TEST(AteTest, TruthIsInterpolatedOverShortGapsOnly) {
  const Trajectory truth = {{0, makePose(0, 0, 0, 0, 0, 0)},
                            {100'000, makePose(1, 0, 0, 0, 0, 0.2)},
                            {500'000, makePose(5, 0, 0, 0, 0, 0.2)}};
  const Trajectory estimate = {{0, truth[0].T_a_b},
                               {25'000, makePose(0.25, 0, 0, 0, 0, 0.05)},
                               {300'000, makePose(99, 0, 0, 0, 0, 0)},
                               {500'900, truth[2].T_a_b}};
  const AteResult result = evaluateAte(estimate, truth, Alignment::kStart, 0.1);
  EXPECT_EQ(result.poses, 4);
  EXPECT_EQ(result.matched, 3);
  EXPECT_NEAR(result.translation_m.max, 0.0, 1e-12);
  EXPECT_NEAR(result.rotation_rmse_deg, 0.0, 1e-6);
}

TEST(AteTest, TrackedShareCountsWhatWasLost) {
  const Trajectory truth = helix(100);
  const Trajectory late(truth.begin() + 20, truth.end());
  EXPECT_DOUBLE_EQ(evaluateAte(late, truth, Alignment::kSe3, 0.1).tracked_share, 0.8);
  // Truth ten times as dense as the estimate.
  Trajectory sparse;
  for (std::size_t i = 0; i < 50; i += 10) {
    sparse.push_back(truth[i]);
  }
  EXPECT_NEAR(evaluateAte(sparse, truth, Alignment::kSe3, 0.1).tracked_share, 0.48, 1e-9);
}

TEST(AteTest, TooLittleInCommonIsAnError) {
  const Trajectory truth = helix(10);
  EXPECT_THAT(errorOf([&] { evaluateAte({}, truth, Alignment::kSim3, 0.1); }),
              HasSubstr("none of the 0 poses"));
  EXPECT_THAT(errorOf([&] {
                evaluateAte({truth[0], truth[1]}, truth, Alignment::kSe3, 0.1);
              }),
              HasSubstr("too few"));
  Trajectory still = truth;
  for (auto& pose : still) {
    pose.T_a_b.translation().setZero();
  }
  EXPECT_THAT(errorOf([&] { evaluateAte(still, truth, Alignment::kSim3, 0.1); }), HasSubstr("does not move"));
}

/// Poses whose errors are drawn from `sigma` about the path, and said to be so.
std::vector<UncertainPose> drawn(const Trajectory& truth, const Eigen::Matrix<double, 6, 1>& sigma) {
  std::mt19937 generator(3);
  std::normal_distribution<double> normal;
  std::vector<UncertainPose> poses;
  for (const common::StampedPose& pose : truth) {
    Eigen::Matrix<double, 6, 1> error;
    for (double& e : error) {
      e = normal(generator);
    }
    // x and y err together.
    error(1) = 0.8 * error(0) + 0.6 * error(1);
    error = error.cwiseProduct(sigma).eval();
    UncertainPose drawn{.pose = pose, .state = poses.size() % 2 == 0 ? 'H' : 'M'};
    drawn.pose.T_a_b.translation() += error.head<3>();
    const Eigen::AngleAxisd turn(error.tail<3>().norm(), error.tail<3>().normalized());
    drawn.pose.T_a_b.linear() = turn * pose.T_a_b.linear();
    drawn.covariance = sigma.cwiseAbs2().asDiagonal();
    drawn.covariance(0, 1) = drawn.covariance(1, 0) = 0.8 * sigma(0) * sigma(1);
    poses.push_back(drawn);
  }
  return poses;
}

TEST(ConsistencyTest, HonestCovariancesHoldNineteenOfTwenty) {
  const Trajectory truth = helix(4000);
  Eigen::Matrix<double, 6, 1> sigma;
  sigma << 0.03, 0.01, 0.02, 0.01, 0.02, 0.03;
  std::vector<UncertainPose> poses = drawn(truth, sigma);
  const auto honest = evaluateConsistency(poses, truth, 0.0);
  ASSERT_EQ(honest.size(), 2);
  for (const char state : {'H', 'M'}) {
    const Consistency& c = honest.at(state);
    EXPECT_EQ(c.poses, 2000);
    EXPECT_NEAR(c.xy, 0.95, 0.015);
    EXPECT_NEAR(c.z, 0.95, 0.015);
    EXPECT_NEAR(c.attitude, 0.95, 0.015);
  }
  for (UncertainPose& pose : poses) {
    pose.covariance(2, 2) *= 0.25;
  }
  const auto bold = evaluateConsistency(poses, truth, 100.0);
  EXPECT_EQ(bold.at('H').poses, 1000) << "the second half of 200 s";
  EXPECT_NEAR(bold.at('H').z, 0.67, 0.05) << "one sigma";
  EXPECT_NEAR(bold.at('H').xy, 0.95, 0.02);
}

TEST(ConsistencyTest, ResultsAreReadOrTheRowIsNamed) {
  const test::TempDir dir;
  const Trajectory path = helix(2);
  common::writeTum(dir.path() / "trajectory_fused.tum", path);
  const std::string numbers = "1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21";
  const auto write = [&](const std::string& second) {
    dir.write("covariance.csv", "time_s,state,covariance\n0.000000,H," + numbers + "\n" + second);
  };
  write("0.050000,M," + numbers + "\n");
  const auto poses = readUncertainPoses(dir.path());
  ASSERT_EQ(poses.size(), 2);
  EXPECT_EQ(poses[1].state, 'M');
  EXPECT_EQ(poses[1].covariance(0, 5), 6.0);
  EXPECT_EQ(poses[1].covariance(2, 1), 8.0);
  EXPECT_EQ(poses[1].covariance(5, 5), 21.0);
  write("0.070000,M," + numbers + "\n");
  EXPECT_THAT(errorOf([&] { readUncertainPoses(dir.path()); }), HasSubstr("covariance.csv:3"));
  write("0.050000,M,1 2 3\n");
  EXPECT_THAT(errorOf([&] { readUncertainPoses(dir.path()); }), HasSubstr("covariance.csv:3"));
}

TEST(CrossingsTest, DriftAndScaleOfTheWaysInM) {
  std::vector<StatedPose> fused;
  common::Trajectory truth;
  for (int i = 0; i < 400; ++i) {
    // 2 cm a picture; a twentieth too long while in M, which lasts from 100 to 200 and from 300 to 302.
    const bool m = (i >= 100 && i < 200) || (i >= 300 && i < 302);
    common::StampedPose pose;
    pose.utime = 1000 * i;
    pose.T_a_b.translation().x() = 0.02 * i;
    truth.push_back(pose);
    pose.T_a_b.translation().x() += 0.001 * std::clamp(i - 100, 0, 99);
    fused.push_back({pose, m ? 'M' : 'H'});
  }
  const auto crossings = findCrossings(fused, truth, 0.5);
  ASSERT_EQ(crossings.size(), 1);
  EXPECT_EQ(crossings.front().utime, 100'000);
  EXPECT_NEAR(crossings.front().way_m, 2.0, 0.25);
  EXPECT_NEAR(crossings.front().drift, 0.05, 0.01);
  EXPECT_NEAR(crossings.front().scale_error, 0.05, 1e-6);
}

TEST(RelationsTest, TruthHasNoError) {
  const Trajectory truth = helix(100);
  std::vector<Relation> relations;
  for (std::size_t i = 0; i + 10 < truth.size(); i += 3) {
    relations.push_back(
        {truth[i].utime + 400, truth[i + 10].utime, truth[i].T_a_b.inverse() * truth[i + 10].T_a_b});
  }
  // Wherever the estimate's frame is.
  const auto result =
      evaluateRelations(moved(truth, makePose(3, -4, 5, 0.7, -0.4, 2.0), 1.0), relations, 0.005);
  EXPECT_EQ(result.matched, result.total);
  EXPECT_NEAR(result.translation_m.max, 0.0, 1e-9);
  EXPECT_NEAR(result.rotation_deg.max, 0.0, 1e-6);
}

TEST(RelationsTest, ErrorsByHand) {
  test::TempDir dir;
  const auto relations = readRelations(
      dir.write("r.relations", "0.0 1.0 1.0 0.0 0 0 0 0.0\n1.0 2.0 1.0 0 0 0 0 0\n7 8 0 0 0 0 0 0\n"));
  const Trajectory estimate = {{0, makePose(0, 0, 0, 0, 0, std::numbers::pi / 2)},
                               {1'000'000, makePose(0, 1.3, 0, 0, 0, std::numbers::pi / 2 - 0.1)},
                               {2'004'000, makePose(0, 1.3, 0, 0, 0, std::numbers::pi / 2 - 0.1)}};
  const auto result = evaluateRelations(estimate, relations, 0.005);
  EXPECT_EQ(result.matched, 2);
  EXPECT_EQ(result.total, 3);
  EXPECT_NEAR(result.translation_m.mean, (0.3 + 1.0) / 2, 1e-12);
  EXPECT_NEAR(result.rotation_deg.max, 0.1 / kDegree, 1e-9);
  EXPECT_THAT(errorOf([&] { evaluateRelations({}, relations, 0.005); }),
              HasSubstr("none of the 3 relations"));
  EXPECT_THAT(errorOf([&] { readRelations(dir.write("bad.relations", "0 1 2\n")); }),
              HasSubstr("bad.relations:1"));
}

TEST(MapTest, PrecisionAndRecallByHand) {
  const std::vector<Eigen::Vector2d> truth = {{0.025, 0.025}, {0.075, 0.025}, {5.025, 0.025}};
  const std::vector<Eigen::Vector2d> map = {{0.025, 0.075}, {-1.0, -1.0}};
  const MapResult result = evaluateMap(map, truth, 0.05);
  EXPECT_DOUBLE_EQ(result.precision, 0.5);
  EXPECT_NEAR(result.recall, 1.0 / 3.0, 1e-12);
  EXPECT_DOUBLE_EQ(evaluateMap(truth, truth, 0.01).precision, 1.0);
}

TEST(MapTest, AgreesWithBruteForce) {
  std::mt19937 generator(3);
  std::uniform_real_distribution<double> place(-2.0, 2.0);
  std::vector<Eigen::Vector2d> a(300);
  std::vector<Eigen::Vector2d> b(300);
  for (std::size_t i = 0; i < a.size(); ++i) {
    a[i] = {place(generator), place(generator)};
    b[i] = {place(generator), place(generator)};
  }
  const auto share = [](const auto& from, const auto& to) {
    double near = 0;
    for (const auto& p : from) {
      near +=
          std::any_of(to.begin(), to.end(), [&](const auto& q) { return (p - q).norm() <= 0.1; }) ? 1.0 : 0.0;
    }
    return near / static_cast<double>(from.size());
  };
  const MapResult result = evaluateMap(a, b, 0.1);
  EXPECT_DOUBLE_EQ(result.precision, share(a, b));
  EXPECT_DOUBLE_EQ(result.recall, share(b, a));
}

TEST(MapTest, MapServerFiles) {
  test::TempDir dir;
  cv::Mat image(2, 3, CV_8UC1, cv::Scalar(205));
  image.at<std::uint8_t>(0, 2) = 0;  // Upper right.
  ASSERT_TRUE(cv::imwrite((dir.path() / "map.pgm").string(), image));
  const std::string yaml =
      "image: map.pgm\nresolution: 0.1\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n";
  auto cells = readOccupiedCells(dir.write("map.yaml", yaml + "origin: [1.0, 2.0, 0.0]\n"));
  ASSERT_EQ(cells.size(), 1U);
  EXPECT_NEAR(cells[0].x(), 1.25, 1e-12);
  EXPECT_NEAR(cells[0].y(), 2.15, 1e-12);
  const Eigen::AlignedBox2d around(Eigen::Vector2d(1.2, 2.1), Eigen::Vector2d(1.3, 2.2));
  EXPECT_EQ(readOccupiedCells(dir.path() / "map.yaml", around).size(), 1U);
  EXPECT_TRUE(
      readOccupiedCells(dir.path() / "map.yaml", around.translated(Eigen::Vector2d(0.1, 0.0))).empty());
  cells = readOccupiedCells(dir.write("map.yaml", yaml + "origin: [1.0, 2.0, 1.5707963267948966]\n"));
  EXPECT_NEAR(cells[0].x(), 0.85, 1e-12);
  EXPECT_NEAR(cells[0].y(), 2.25, 1e-12);

  EXPECT_THAT(errorOf([&] { readOccupiedCells(dir.write("map.yaml", yaml)); }), HasSubstr("origin"));
  EXPECT_THAT(errorOf([&] { readOccupiedCells(dir.write("map.yaml", yaml + "origin: [1.0, .inf, 0.0]\n")); }),
              HasSubstr("impossibly large"));
  EXPECT_THAT(errorOf([&] { readOccupiedCells(dir.write("map.yaml", "image: [")); }), HasSubstr("map.yaml"));
  EXPECT_THAT(errorOf([&] { readOccupiedCells(dir.path() / "none.yaml"); }), HasSubstr("none.yaml"));
  ASSERT_TRUE(cv::imwrite((dir.path() / "map.pgm").string(), cv::Mat(2, 3, CV_8UC1, cv::Scalar(254))));
  EXPECT_THAT(errorOf([&] { readOccupiedCells(dir.write("map.yaml", yaml + "origin: [1.0, 2.0, 0.0]\n")); }),
              HasSubstr("no cell is occupied"));
  dir.write("map.pgm", "P5\n70000 70000\n255\nfew");
  EXPECT_THAT(errorOf([&] { readOccupiedCells(dir.path() / "map.yaml"); }),
              AllOf(HasSubstr("map.pgm"), HasSubstr("no picture")));
}

}  // namespace
}  // namespace rubble::tools
