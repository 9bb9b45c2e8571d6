#include "slam_lidar/grid_slam.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <span>

#include "common/error.h"
#include "common/files.h"
#include "support/error_text.h"
#include "synthetic_room.h"

namespace rubble::slam_lidar {
namespace {

constexpr common::Utime kPeriod = 200'000;

struct DriveLog {
  std::vector<ScanResult> results;
  std::vector<common::Pose2> truth;
};

DriveLog drive(GridSlam& slam, const SyntheticRoom& room, const common::Pose2& T_world_start, int from,
               int to) {
  DriveLog run;
  const auto poses = syntheticDrive(to);
  for (int i = from; i < to; ++i) {
    const common::Pose2 T = T_world_start * poses[static_cast<std::size_t>(i)];
    const auto ranges = room.scan(T);
    run.results.push_back(slam.addScan(SyntheticRoom::input((i + 1) * kPeriod, ranges)));
    run.truth.push_back(T);
  }
  return run;
}

TEST(GridSlam, FollowsTheTruthWithoutAnyPriorWhereverTheWorldLies) {
  for (const common::Pose2& T_world_start :
       {common::Pose2{}, common::Pose2{10'000.0, -10'000.0, 2.0}, common::Pose2{-3.3, 7.1, -0.7}}) {
    const SyntheticRoom room(T_world_start);
    GridSlam slam(GridSlamConfig{}, T_world_start);
    const DriveLog run = drive(slam, room, T_world_start, 0, 80);
    for (std::size_t i = 0; i < run.results.size(); ++i) {
      ASSERT_LT(distance(run.results[i].T_world_lidar, run.truth[i]), 0.1) << i;
      ASSERT_LT(std::abs(common::wrapAngle(run.results[i].T_world_lidar.yaw - run.truth[i].yaw)), 0.02) << i;
      ASSERT_EQ(run.results[i].status, MatchStatus::kGood) << i;
    }
  }
}

TEST(GridSlam, AStandingRobotStandsFromTheFirstScanOn) {
  std::mt19937 random(3);
  std::normal_distribution<float> noise(0.0F, 0.01F);
  for (int start = 0; start < 20; ++start) {
    const common::Pose2 T_world_start{0.013 * start, -0.007 * start, 0.05 * start};
    const SyntheticRoom room(T_world_start);
    GridSlam slam(GridSlamConfig{}, T_world_start);
    for (int i = 1; i <= 20; ++i) {
      std::vector<float> ranges = room.scan(T_world_start);
      for (float& range : ranges) {
        range += noise(random);
      }
      ScanInput input = SyntheticRoom::input(i * kPeriod, ranges);
      input.hold_write = true;
      if (i > 8) {
        slam.commitUntil(input.scan.utime - 8 * kPeriod);
      }
      const ScanResult result = slam.addScan(input);
      EXPECT_LT(distance(result.T_world_lidar, T_world_start), 0.02) << "start " << start << " scan " << i;
    }
  }
}

TEST(GridSlam, TwoRunsAreIdentical) {
  const SyntheticRoom room;
  GridSlam a{GridSlamConfig{}};
  GridSlam b{GridSlamConfig{}};
  drive(a, room, {}, 0, 40);
  drive(b, room, {}, 0, 40);
  EXPECT_EQ(a.serialise(), b.serialise());
}

TEST(GridSlam, ARestoredOneGoesOnIdentically) {
  const SyntheticRoom room;
  GridSlam slam{GridSlamConfig{}};
  drive(slam, room, {}, 0, 30);
  GridSlam restored = GridSlam::restore(GridSlamConfig{}, slam.serialise());
  drive(slam, room, {}, 30, 60);
  drive(restored, room, {}, 30, 60);
  EXPECT_EQ(slam.serialise(), restored.serialise());
}

TEST(GridSlam, BadStatesAreErrors) {
  const SyntheticRoom room;
  GridSlam slam{GridSlamConfig{}};
  drive(slam, room, {}, 0, 3);
  const auto bytes = slam.serialise();
  for (std::size_t size = 0; size < bytes.size(); size += 1 + bytes.size() / 300) {
    EXPECT_THROW(GridSlam::restore(GridSlamConfig{}, std::span(bytes).first(size)), common::Error);
  }
  for (std::size_t i = 0; i < bytes.size(); i += 1 + bytes.size() / 300) {
    auto damaged = bytes;
    damaged[i] ^= 0x10;
    EXPECT_THROW(GridSlam::restore(GridSlamConfig{}, damaged), common::Error);
  }
  GridSlamConfig other;
  other.map.cell_size = 0.1;
  EXPECT_THROW(GridSlam::restore(other, bytes), common::Error);
}

TEST(GridSlam, StatesThatCannotBeAreErrorsWhateverTheirChecksum) {
  const SyntheticRoom room;
  GridSlam slam{GridSlamConfig{}};
  drive(slam, room, {}, 0, 3);
  const auto saved = slam.serialise();
  const auto error = [&](std::size_t at, const auto& value) {
    auto bytes = saved;
    std::memcpy(bytes.data() + at, &value, sizeof value);
    const std::uint32_t crc = common::crc32(std::span(bytes).first(bytes.size() - sizeof crc));
    std::memcpy(bytes.data() + bytes.size() - sizeof crc, &crc, sizeof crc);
    return test::errorOf([&] { GridSlam::restore(GridSlamConfig{}, bytes); });
  };
  using ::testing::HasSubstr;
  constexpr std::size_t kUtime = 9;
  constexpr std::size_t kPose = 17;
  constexpr std::size_t kTwist = 65;
  constexpr std::size_t kLostScans = 113;
  constexpr std::size_t kWindow = 148;
  EXPECT_THAT(error(kUtime, std::int64_t{-1}), HasSubstr("LiDAR SLAM state: a time before 1970"));
  EXPECT_THAT(error(kPose, std::nan("")), HasSubstr("an impossible pose"));
  EXPECT_THAT(error(kPose, 1e30), HasSubstr("an impossible pose"));
  EXPECT_THAT(error(kTwist, 1e30), HasSubstr("an impossible number"));
  EXPECT_THAT(error(kLostScans, -1), HasSubstr("an impossible number of scans"));
  EXPECT_THAT(error(kWindow, std::numeric_limits<std::int32_t>::max()), HasSubstr("impossibly far away"));
}

TEST(GridSlam, BadInputIsAnErrorOrNoMatchAndChangesNothing) {
  const SyntheticRoom room;
  GridSlam slam{GridSlamConfig{}};
  drive(slam, room, {}, 0, 10);
  const auto before = slam.serialise();
  const auto ranges = room.scan({});
  EXPECT_THROW(slam.addScan(SyntheticRoom::input(10 * kPeriod, ranges)), common::Error) << "same time";
  EXPECT_THROW(slam.addScan(SyntheticRoom::input(0, ranges)), common::Error) << "backwards";
  ScanInput input = SyntheticRoom::input(11 * kPeriod, ranges);
  input.scan.angle_step = 0.0;
  EXPECT_THROW(slam.addScan(input), common::Error);
  input = SyntheticRoom::input(11 * kPeriod, ranges);
  input.attitude_last.pitch = std::nan("");
  EXPECT_THROW(slam.addScan(input), common::Error);
  input.attitude_last.pitch = 0.0;
  input.prior = MotionPrior{{std::nan(""), 0.0, 0.0}};
  EXPECT_THROW(slam.addScan(input), common::Error);
  EXPECT_EQ(slam.serialise(), before);

  const std::vector<float> nothing(361, std::numeric_limits<float>::quiet_NaN());
  EXPECT_FALSE(slam.addScan(SyntheticRoom::input(11 * kPeriod, nothing)).matched);
  EXPECT_FALSE(slam.addScan(SyntheticRoom::input(12 * kPeriod, {})).matched);
  EXPECT_EQ(slam.addScan(SyntheticRoom::input(13 * kPeriod, room.scan(syntheticDrive(13).back()))).status,
            MatchStatus::kGood);
}

TEST(GridSlam, IgnoredAndMatchOnlyScansWriteNothing) {
  const SyntheticRoom room;
  GridSlam slam{GridSlamConfig{}};
  drive(slam, room, {}, 0, 60);
  const auto revision = slam.mapRevision();
  const auto poses = syntheticDrive(60);
  // Ignored while it is carried back, and then matched again on the way it knows.
  for (int i = 60; i < 64; ++i) {
    const auto ranges = room.scan(poses[40]);
    ScanInput input = SyntheticRoom::input((i + 1) * kPeriod, ranges);
    input.mode = ScanMode::kIgnore;
    EXPECT_FALSE(slam.addScan(input).matched);
  }
  MatchStatus last = MatchStatus::kLost;
  for (int i = 64; i < 80; ++i) {
    const common::Pose2& T = poses[static_cast<std::size_t>(i - 24)];
    const auto ranges = room.scan(T);
    ScanInput input = SyntheticRoom::input((i + 1) * kPeriod, ranges);
    input.mode = ScanMode::kMatchOnly;
    const ScanResult result = slam.addScan(input);
    last = result.status;
    if (last == MatchStatus::kGood) {
      EXPECT_LT(distance(result.T_world_lidar, T), 0.1);
    }
  }
  EXPECT_EQ(last, MatchStatus::kGood) << "found again";
  EXPECT_EQ(slam.mapRevision(), revision);
}

TEST(GridSlam, AMapCanBeginUnderAMovingRobot) {
  const SyntheticRoom room;
  std::vector<common::Pose2> poses{{0.4, -0.3, 0.5}};
  for (int i = 1; i < 120; ++i) {
    poses.push_back(poses.back() * common::Pose2{0.01, 0.0, 0.02});
  }
  GridSlam slam(GridSlamConfig{}, poses.front());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const auto ranges = room.scan(poses[i]);
    ScanInput input = SyntheticRoom::input(static_cast<common::Utime>(i + 1) * kPeriod, ranges);
    if (i < 30) {
      input.mode = ScanMode::kWriteOnly;
      if (i > 0) {
        input.prior = MotionPrior{poses[i - 1].inverse() * poses[i]};
      }
    }
    const ScanResult result = slam.addScan(input);
    EXPECT_EQ(result.matched, i >= 30);
    EXPECT_EQ(result.status == MatchStatus::kGood, i >= 30) << "nobody should follow what nobody matched";
    EXPECT_LT(distance(result.T_world_lidar, poses[i]), 0.01) << i;
    EXPECT_LT(std::abs(common::wrapAngle(result.T_world_lidar.yaw - poses[i].yaw)), 0.005) << i;
  }
  EXPECT_GE(slam.mapRevision(), 29U);
}

TEST(GridSlam, TiltedScansAreMatchedButNotWritten) {
  const SyntheticRoom room;
  GridSlam slam{GridSlamConfig{}};
  drive(slam, room, {}, 0, 20);
  const auto revision = slam.mapRevision();
  const auto poses = syntheticDrive(60);
  for (int i = 20; i < 60; ++i) {
    const auto ranges = room.scan(poses[static_cast<std::size_t>(i)]);
    ScanInput input = SyntheticRoom::input((i + 1) * kPeriod, ranges);
    input.attitude_first = {0.03, 0.03};  // 2.4 degrees together.
    const ScanResult result = slam.addScan(input);
    EXPECT_TRUE(result.matched);
    EXPECT_FALSE(result.written || result.pending);
  }
  EXPECT_EQ(slam.mapRevision(), revision);
}

TEST(GridSlam, AKidnappedRobotIsLostWritesNothingAndIsFoundAgain) {
  const SyntheticRoom room;
  GridSlam slam{GridSlamConfig{}};
  drive(slam, room, {}, 0, 60);
  const auto revision = slam.mapRevision();
  const common::Pose2 T{0.9, 0.5, 0.8};
  slam.relocalise({0.0, 0.0, 0.0}, 3.0, 3.2);
  const auto ranges = room.scan(T);
  ScanResult result;
  for (int i = 60; i < 64; ++i) {
    result = slam.addScan(SyntheticRoom::input((i + 1) * kPeriod, ranges));
    if (result.status != MatchStatus::kGood) {
      EXPECT_EQ(slam.mapRevision(), revision);
    }
  }
  EXPECT_EQ(result.status, MatchStatus::kGood);
  EXPECT_LT(distance(result.T_world_lidar, T), 0.1);
}

TEST(GridSlam, HeldScansAreWrittenOnCommitOnly) {
  const SyntheticRoom room;
  GridSlam slam{GridSlamConfig{}};
  drive(slam, room, {}, 0, 20);
  const auto revision = slam.mapRevision();
  const auto poses = syntheticDrive(60);
  std::vector<common::Utime> held;
  for (int i = 20; i < 60; ++i) {
    const auto ranges = room.scan(poses[static_cast<std::size_t>(i)]);
    ScanInput input = SyntheticRoom::input((i + 1) * kPeriod, ranges);
    input.hold_write = true;
    if (slam.addScan(input).pending) {
      held.push_back(input.scan.utime);
    }
  }
  ASSERT_GE(held.size(), 4U);
  EXPECT_EQ(slam.mapRevision(), revision);
  EXPECT_EQ(slam.pendingCount(), held.size());
  EXPECT_EQ(slam.commitUntil(held[1]), 2);
  EXPECT_EQ(slam.mapRevision(), revision + 2);
  EXPECT_EQ(slam.discardPending(held[3]), static_cast<int>(held.size()) - 3);
  EXPECT_EQ(slam.pendingCount(), 1U);
  GridSlam restored = GridSlam::restore(GridSlamConfig{}, slam.serialise());
  EXPECT_EQ(restored.pendingCount(), 1U);
  EXPECT_EQ(restored.commitUntil(held.back()), 1);
}

TEST(GridSlam, CovarianceGrowsAlongABareCorridor) {
  // Two walls 2 m apart and nothing else; ranges a centimetre or so off.
  GridSlam slam{GridSlamConfig{}};
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0.0, 0.01);
  ScanResult result;
  for (int k = 0; k < 60; ++k) {
    std::vector<float> ranges(361);
    for (std::size_t i = 0; i < ranges.size(); ++i) {
      const double a = SyntheticRoom::kFirstAngle + static_cast<double>(i) * SyntheticRoom::kAngleStep;
      const double r = 1.0 / std::max(std::abs(std::sin(a)), 1e-9);
      ranges[i] = static_cast<float>(r < 6.0 ? r + noise(random) : 100.0);
    }
    ScanInput input = SyntheticRoom::input((k + 1) * kPeriod, ranges);
    input.prior = MotionPrior{{0.05, 0.0, 0.0}};
    result = slam.addScan(input);
  }
  EXPECT_GT(result.covariance(0, 0), 10.0 * result.covariance(1, 1));
  EXPECT_GT(result.T_world_lidar.x, 2.0) << "where the scan says nothing the pose keeps to its seed";
}

TEST(GridSlam, TilesAreSortedAndCarryRevisions) {
  const SyntheticRoom room;
  GridSlam slam{GridSlamConfig{}};
  drive(slam, room, {}, 0, 20);
  const auto tiles = slam.tiles();
  ASSERT_FALSE(tiles.empty());
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    EXPECT_GT(tiles[i].revision, 0U);
    EXPECT_LE(tiles[i].revision, slam.mapRevision());
    EXPECT_EQ(slam.tileCells(tiles[i].x, tiles[i].y).size(), 1024U);
    if (i > 0) {
      EXPECT_LT(std::pair(tiles[i - 1].y, tiles[i - 1].x), std::pair(tiles[i].y, tiles[i].x));
    }
  }
  EXPECT_THROW(slam.tileCells(9999, 9999), common::Error);
}

}  // namespace
}  // namespace rubble::slam_lidar
