#include "correlative_search.h"

#include <gtest/gtest.h>

#include "grid_map.h"
#include "scan_projector.h"
#include "synthetic_room.h"

namespace rubble::slam_lidar {
namespace {

class CorrelativeSearchTest : public testing::Test {
 protected:
  CorrelativeSearchTest() : map_(config_), projector_(config_.scan) {
    for (const common::Pose2& T : syntheticDrive(40)) {
      project(T);
      map_.write(T, scan_.rays);
    }
  }
  void project(const common::Pose2& T_world_lidar) {
    const auto ranges = room_.scan(T_world_lidar);
    projector_.project(SyntheticRoom::input(0, ranges).scan, {}, {}, 0.0, Eigen::Vector3d::Zero(), scan_);
  }

  GridSlamConfig config_;
  SyntheticRoom room_;
  GridMap map_;
  ScanProjector projector_;
  ProjectedScan scan_;
};

TEST_F(CorrelativeSearchTest, FindsWhatAnExhaustiveSearchOfTheSameTableFinds) {
  const common::Pose2 T_true{0.7, 0.3, 0.5};
  project(T_true);
  CorrelativeSearch search;
  const SearchWindow window{{0.5, 0.1, 0.2}, 0.8, 0.6};
  const TiledGrid& coarse = map_.levels().back();
  const auto found = search.search(coarse, scan_.points, window, 0.0, 4);
  ASSERT_FALSE(found.empty());
  // Oracle: all points, steps ten times finer.
  double best = -1e9;
  common::Pose2 T_best;
  for (double yaw = -0.6; yaw <= 0.6; yaw += 0.01) {
    for (double y = -0.8; y <= 0.8; y += 0.05) {
      for (double x = -0.8; x <= 0.8; x += 0.05) {
        const common::Pose2 T{0.5 + x, 0.1 + y, 0.2 + yaw};
        const double value = evaluate(coarse.view(), scan_.points, T).quality();
        if (value > best) {
          best = value;
          T_best = T;
        }
      }
    }
  }
  EXPECT_LT(distance(found.front().T_world_lidar, T_best), 0.3);
  EXPECT_LT(std::abs(common::wrapAngle(found.front().T_world_lidar.yaw - T_best.yaw)), 0.1);
  EXPECT_LT(distance(T_best, T_true), 0.15);
}

TEST_F(CorrelativeSearchTest, CandidatesAreOrderedAndApart) {
  project({0.2, 0.1, 0.3});
  CorrelativeSearch search;
  const auto found = search.search(map_.levels().back(), scan_.points, {{}, 3.0, 3.2}, 0.1, 6);
  ASSERT_GE(found.size(), 2U);
  for (std::size_t i = 1; i < found.size(); ++i) {
    EXPECT_GE(found[i - 1].value, found[i].value);
  }
}

TEST_F(CorrelativeSearchTest, NoPointsNoCandidates) {
  PointSet empty;
  empty.pad();
  CorrelativeSearch search;
  EXPECT_TRUE(search.search(map_.levels().back(), empty, {{}, 1.0, 1.0}, 0.1, 6).empty());
}

}  // namespace
}  // namespace rubble::slam_lidar
