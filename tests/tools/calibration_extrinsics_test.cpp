#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "calibration/extrinsics.h"
#include "calibration/recording.h"
#include "support/error_text.h"
#include "support/temp_dir.h"

namespace rubble::calibration {
namespace {

using test::errorOf;
using ::testing::HasSubstr;

constexpr double kDegree = 0.017453292519943295;
const Board kBoard{{9, 6}, 0.09};

common::Pose3 poseOf(const common::RollPitchYaw& rpy, const Eigen::Vector3d& translation) {
  common::Pose3 T = common::Pose3::Identity();
  T.linear() = common::rotationFromRpy(rpy);
  T.translation() = translation;
  return T;
}

/// The LiDAR lies 12 cm below the camera, looks the same way and is 3 degrees off.
common::Pose3 truth() {
  return poseOf({90.0 * kDegree, -87.0 * kDegree, 2.0 * kDegree}, {0.03, 0.12, -0.05});
}

/// What a LiDAR sees of a board in a round hall of 4 m, with noise; on black 3 cm too short.
Scan scanOf(const BoardPair& pair, double noise, std::mt19937& random) {
  const common::Pose3 T_board_lidar = pair.T_camera_board.inverse() * truth();
  std::normal_distribution<double> error(0.0, noise);
  Scan scan{-1.5708, 0.006135923, {}};
  for (int i = 0; i < 512; ++i) {
    const double angle = scan.angle_min + i * scan.angle_step;
    const Eigen::Vector3d origin = T_board_lidar.translation();
    const Eigen::Vector3d ray =
        T_board_lidar.linear() * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0.0);
    const double range = -origin.z() / ray.z();
    const Eigen::Vector3d hit = (origin + range * ray) / kBoard.square;
    const bool is_board = range > 0.0 && hit.x() > -1.5 && hit.x() < 9.5 && hit.y() > -1.5 && hit.y() < 6.5;
    const bool is_squares = hit.x() > -1.0 && hit.x() < 9.0 && hit.y() > -1.0 && hit.y() < 6.0;
    const bool is_black = static_cast<int>(std::floor(hit.x()) + std::floor(hit.y())) % 2 == 0;
    scan.ranges.push_back((is_board ? range : 4.0) - (is_board && is_squares && is_black ? 0.03 : 0.0) +
                          error(random));
  }
  return scan;
}

/// Boards turned about the vertical and tipped by up to `tilt`, at 0.8 to 2.2 m.
std::vector<BoardPair> pairsWith(std::size_t count, double tilt, double noise) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> share(-1.0, 1.0);
  std::vector<BoardPair> pairs;
  for (std::size_t i = 0; i < count; ++i) {
    const double distance = 1.5 + 0.7 * share(random);
    BoardPair pair;
    pair.name = std::to_string(i);
    const common::Pose3 T_camera_middle =
        poseOf({tilt * share(random), tilt * share(random), 0.3 * share(random)},
               {0.2 * share(random), 0.1 + 0.1 * share(random), distance});
    pair.T_camera_board = T_camera_middle * poseOf({}, {-0.36, -0.225, 0.0});
    const Scan scan = scanOf(pair, noise, random);
    pair.points = scan.points();
    pair.lines = straightRuns(scan);
    pairs.push_back(pair);
  }
  return pairs;
}

void expectTruth(const common::Pose3& T_camera_lidar, double angle, double distance) {
  const common::Pose3 error = truth().inverse() * T_camera_lidar;
  EXPECT_LT(Eigen::AngleAxisd(error.linear()).angle(), angle);
  EXPECT_LT((T_camera_lidar.translation() - truth().translation()).norm(), distance);
}

TEST(ExtrinsicsTest, ExactBoardsGiveTheExtrinsics) {
  expectTruth(fitExtrinsics(kBoard, pairsWith(20, 50.0 * kDegree, 0.0)).T_camera_lidar, 0.02 * kDegree, 5e-4);
}

TEST(ExtrinsicsTest, NoiseAndWrongPairsAreSurvived) {
  std::vector<BoardPair> pairs = pairsWith(40, 50.0 * kDegree, 0.008);
  for (const std::size_t wrong : {3U, 11U, 19U, 27U, 35U}) {  // Scans of another moment.
    pairs[wrong].points = pairs[wrong + 1].points;
    pairs[wrong].lines = pairs[wrong + 1].lines;
  }
  const Extrinsics fit = fitExtrinsics(kBoard, pairs);
  expectTruth(fit.T_camera_lidar, 0.2 * kDegree, 0.005);
  EXPECT_LT(fit.deviations.head<3>().maxCoeff(), 0.5 * kDegree);
  EXPECT_LT(fit.deviations.tail<3>().maxCoeff(), 0.01);
}

TEST(ExtrinsicsTest, TheFitKnowsNothingOfThePairsLeftOut) {
  std::vector<BoardPair> pairs = pairsWith(12, 50.0 * kDegree, 0.005);
  const common::Pose3 before = fitsWithout(kBoard, pairs, 12)[4];
  pairs[4].T_camera_board.translation().z() += 0.04;
  EXPECT_TRUE(fitsWithout(kBoard, pairs, 12)[4].isApprox(before, 0.0));
}

TEST(ExtrinsicsTest, ParallelBoardsAreRefused) {
  EXPECT_THAT(errorOf([] { fitExtrinsics(kBoard, pairsWith(20, 0.0, 0.005)); }),
              HasSubstr("do not determine the camera's"));
}

TEST(ExtrinsicsTest, TooFewPairsAreRefused) {
  EXPECT_THAT(errorOf([] { fitExtrinsics(kBoard, pairsWith(4, 0.8, 0.005)); }), HasSubstr("4 pairs"));
}

TEST(RecordingTest, BadFilesAreNamedWithTheirLine) {
  const test::TempDir dir;
  const auto calib = dir.write("calib.txt", "width 640\nfx abc\n");
  EXPECT_THAT(errorOf([&] { readCalib(calib); }), HasSubstr("calib.txt:2: `abc` is no fx"));
  dir.write("calib.txt", "width 640\nheight 480\n");
  EXPECT_THAT(errorOf([&] { readCalib(calib); }), HasSubstr("says no `fx`"));
  const Lens lens;
  EXPECT_THAT(errorOf([&] { readPairs(dir.path(), lens, kBoard); }), HasSubstr("images.csv"));
  dir.write("images.csv", "0,a.png\n0,b.png\n");
  EXPECT_THAT(errorOf([&] { readPairs(dir.path(), lens, kBoard); }),
              HasSubstr("images.csv:2: index 0 is there twice"));
  dir.write("images.csv", "# index,file\n0,a.png\n");
  dir.write("scans.csv", "0,-1.57,0.006,1.0,x\n");
  EXPECT_THAT(errorOf([&] { readPairs(dir.path(), lens, kBoard); }),
              HasSubstr("scans.csv:1: `x` is no range"));
  dir.write("scans.csv", "0,-1.57,0.006,1.0,inf\n1,-1.57,0.006,1.0\n");
  const Pairs pairs = readPairs(dir.path(), lens, kBoard);
  ASSERT_EQ(pairs.left_out.size(), 2U);
  EXPECT_EQ(pairs.left_out[1].why, "is no readable picture");
  EXPECT_THAT(errorOf([] { parseBoard("9", 0.09); }), HasSubstr("write e.g. 9x6"));
}

}  // namespace
}  // namespace rubble::calibration
