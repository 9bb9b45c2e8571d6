#include "scan_projector.h"

#include <gtest/gtest.h>

#include "synthetic_room.h"

namespace rubble::slam_lidar {
namespace {

const std::vector<float> kRanges(181, 2.0F);

LidarScan halfCircle() { return {0, -std::numbers::pi / 2.0, std::numbers::pi / 180.0, kRanges}; }

TEST(ScanProjector, TiltedPointsEqualTheRotationOfTheWholePoint) {
  GridSlamConfig::Scan config;
  config.height_above_floor = 5.0;
  config.slice = 5.0;
  ScanProjector projector(config);
  ProjectedScan out;
  const Attitude first{0.1, -0.2};
  const Attitude last{-0.05, 0.15};
  projector.project(halfCircle(), first, last, 0.0, Eigen::Vector3d::Zero(), out);
  ASSERT_EQ(out.rays.size(), kRanges.size());
  for (std::size_t i = 0; i < out.rays.size(); ++i) {
    const double t = static_cast<double>(i) / 180.0;
    const double a = -std::numbers::pi / 2.0 + static_cast<double>(i) * std::numbers::pi / 180.0;
    const Eigen::Vector3d p = common::rotationFromRpy({std::lerp(first.roll, last.roll, t),
                                                       std::lerp(first.pitch, last.pitch, t), 0.0}) *
                              Eigen::Vector3d(2.0 * std::cos(a), 2.0 * std::sin(a), 0.0);
    EXPECT_NEAR(static_cast<double>(out.rays[i].x), p.x(), 1e-5);
    EXPECT_NEAR(static_cast<double>(out.rays[i].y), p.y(), 1e-5);
  }
}

TEST(ScanProjector, BeamsThatMeetFloorOrCeilingAreDropped) {
  GridSlamConfig::Scan config;
  config.height_above_floor = 0.3;
  config.height_below_ceiling = 0.4;
  config.height_margin = 0.05;
  config.slice = 5.0;
  ScanProjector projector(config);
  ProjectedScan out;
  // Positive pitch: the front goes down. 2 m ahead lies 0.4 m lower.
  projector.project(halfCircle(), {0.0, 0.2}, {0.0, 0.2}, 0.0, Eigen::Vector3d::Zero(), out);
  ASSERT_FALSE(out.rays.empty());
  for (const RayEnd& ray : out.rays) {
    EXPECT_LT(static_cast<double>(ray.x) * std::tan(0.2), 0.25 + 1e-6);
  }
  projector.project(halfCircle(), {0.0, -0.2}, {0.0, -0.2}, 0.0, Eigen::Vector3d::Zero(), out);
  for (const RayEnd& ray : out.rays) {
    EXPECT_LT(static_cast<double>(ray.x) * std::tan(0.2), 0.35 + 1e-6);
  }
}

TEST(ScanProjector, WhatEndsInAnotherSliceIsMatchedOnly) {
  GridSlamConfig::Scan config;
  config.slice = 0.05;
  ScanProjector projector(config);
  ProjectedScan out;
  // 2 m ahead lies 0.08 m lower, 2 m aside on the LiDAR's height.
  projector.project(halfCircle(), {0.0, 0.04}, {0.0, 0.04}, 0.0, Eigen::Vector3d::Zero(), out);
  EXPECT_EQ(out.points.size(), kRanges.size());
  ASSERT_FALSE(out.rays.empty());
  EXPECT_LT(out.rays.size(), kRanges.size());
  for (const RayEnd& ray : out.rays) {
    EXPECT_LE(static_cast<double>(ray.x) * std::tan(0.04), 0.05 + 1e-6);
  }
  // 6 cm higher the slice is where the beams ahead end.
  projector.project(halfCircle(), {0.0, 0.04}, {0.0, 0.04}, 0.06, Eigen::Vector3d::Zero(), out);
  EXPECT_EQ(out.points.size(), kRanges.size());
  ASSERT_FALSE(out.rays.empty());
  for (const RayEnd& ray : out.rays) {
    EXPECT_GE(static_cast<double>(ray.x) * std::tan(0.04), 0.01 - 1e-6);
  }
  projector.project(halfCircle(), {}, {}, 0.06, Eigen::Vector3d::Zero(), out);
  EXPECT_TRUE(out.rays.empty());
}

TEST(ScanProjector, UndoesTheMotionDuringTheSweep) {
  const SyntheticRoom room;
  const double rate = 3.0;
  GridSlamConfig::Scan config;
  config.sweep_duration = 0.1;
  std::vector<float> ranges(SyntheticRoom::kBeams);
  for (int i = 0; i < SyntheticRoom::kBeams; ++i) {
    const double t = config.sweep_duration * i / SyntheticRoom::kBeams;
    ranges[static_cast<std::size_t>(i)] = static_cast<float>(
        room.range({0.0, 0.0, rate * t}, SyntheticRoom::kFirstAngle + i * SyntheticRoom::kAngleStep));
  }
  ScanProjector projector(config);
  ProjectedScan out;
  projector.project(SyntheticRoom::input(0, ranges).scan, {}, {}, 0.0, Eigen::Vector3d(0, 0, rate), out);
  ASSERT_EQ(out.rays.size(), ranges.size());
  for (const RayEnd& ray : out.rays) {
    const double x = static_cast<double>(ray.x);
    const double y = static_cast<double>(ray.y);
    EXPECT_NEAR(std::hypot(x, y), room.range({}, std::atan2(y, x)), 1e-4);
  }
}

TEST(ScanProjector, IgnoresRangesThatAreNoHits) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  const std::vector<float> ranges = {nan, inf, -inf, 0.0F, -1.0F, 81.9F, 1e30F, 2.0F};
  ScanProjector projector(GridSlamConfig::Scan{});
  ProjectedScan out;
  projector.project({0, 0.0, 0.1, ranges}, {}, {}, 0.0, Eigen::Vector3d::Zero(), out);
  EXPECT_EQ(out.points.size(), 1U);
}

}  // namespace
}  // namespace rubble::slam_lidar
