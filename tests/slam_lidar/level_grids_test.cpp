#include "level_grids.h"

#include <gtest/gtest.h>

#include "common/byte_stream.h"
#include "common/error.h"
#include "synthetic_room.h"

namespace rubble::slam_lidar {
namespace {

constexpr common::Utime kPeriod = 25'000;
const common::Pose2 kPlatform{20.0, -5.0, 0.3};

class LevelGridsTest : public testing::Test {
 protected:
  /// Drives through a room at `T_world_start`.
  void drive(const common::Pose2& T_world_start, int scans = 40) {
    const SyntheticRoom room(T_world_start);
    for (const common::Pose2& T : syntheticDrive(scans)) {
      now_ += kPeriod;
      const auto ranges = room.scan(T_world_start * T);
      grids_.present().addScan(SyntheticRoom::input(now_, ranges));
    }
  }
  std::vector<std::vector<std::uint8_t>> cells() {
    std::vector<std::vector<std::uint8_t>> cells;
    for (const TileInfo& tile : grids_.present().tiles()) {
      cells.push_back(grids_.present().tileCells(tile.x, tile.y));
    }
    return cells;
  }

  common::Utime now_ = 0;
  LevelGrids grids_{GridSlamConfig{}, {}};
};

TEST_F(LevelGridsTest, NoLevelTouchesAnother) {
  drive({});
  const auto ground = cells();
  const common::Pose2 pose = grids_.present().pose();
  grids_.begin(1, kPlatform, 1.2);
  EXPECT_EQ(grids_.level(), 1);
  EXPECT_DOUBLE_EQ(grids_.floor(), 1.2);
  EXPECT_EQ(grids_.present().mapRevision(), 0U);
  drive(kPlatform);
  const auto platform = cells();
  grids_.enter(0);
  EXPECT_EQ(cells(), ground);
  EXPECT_DOUBLE_EQ(grids_.floor(), 0.0);
  EXPECT_GT(distance(grids_.present().pose(), pose), 10.0) << "it is where the robot was on the other level";
  grids_.enter(1);
  EXPECT_EQ(cells(), platform);
}

TEST_F(LevelGridsTest, WhatWaitedForConfirmationIsForgottenWithTheLevel) {
  drive({});
  const SyntheticRoom room;
  const auto ranges = room.scan(common::Pose2{0.6, 0.3, 0.4} * grids_.present().pose());
  ScanInput input = SyntheticRoom::input(now_ + kPeriod, ranges);
  input.hold_write = true;
  grids_.present().relocalise(common::Pose2{0.6, 0.3, 0.4} * grids_.present().pose(), 0.5, 0.3);
  for (int i = 0; i < 10 && grids_.present().pendingCount() == 0; ++i) {
    input.scan.utime += kPeriod;
    grids_.present().addScan(input);
  }
  ASSERT_GT(grids_.present().pendingCount(), 0U);
  const auto revision = grids_.present().mapRevision();
  grids_.begin(1, kPlatform, 1.2);
  grids_.enter(0);
  EXPECT_EQ(grids_.present().commitUntil(input.scan.utime), 0);
  EXPECT_EQ(grids_.present().mapRevision(), revision);
}

TEST_F(LevelGridsTest, OtherLevelsAreRepeatedInTurn) {
  drive({});
  EXPECT_EQ(grids_.nextMaps(1).size(), 1U);
  grids_.begin(2, kPlatform, 1.2);
  drive(kPlatform);
  grids_.begin(5, kPlatform, 2.4);
  drive(kPlatform);
  std::vector<std::int32_t> others;
  for (int i = 0; i < 4; ++i) {
    const auto maps = grids_.nextMaps(1);
    ASSERT_EQ(maps.size(), 2U);
    EXPECT_EQ(maps[0].level, 5);
    others.push_back(maps[1].level);
  }
  EXPECT_EQ(others[0], others[2]);
  EXPECT_EQ(others[1], others[3]);
  EXPECT_EQ(others[0] + others[1], 2);
  grids_.remainingMaps(1);
  EXPECT_TRUE(grids_.remainingMaps(1).empty());
}

TEST_F(LevelGridsTest, ComeBackAsTheyWere) {
  drive({});
  grids_.begin(1, kPlatform, 1.2);
  drive(kPlatform);
  const auto bytes = grids_.serialise();
  LevelGrids again = LevelGrids::restore(GridSlamConfig{}, bytes);
  EXPECT_EQ(again.serialise(), bytes);
  EXPECT_EQ(again.level(), 1);
  EXPECT_DOUBLE_EQ(again.floor(), 1.2);
  again.enter(0);
  grids_.enter(0);
  EXPECT_EQ(again.serialise(), grids_.serialise());
}

TEST_F(LevelGridsTest, DamageIsRefused) {
  drive({}, 3);
  auto bytes = grids_.serialise();
  EXPECT_THROW(LevelGrids::restore(GridSlamConfig{}, std::span(bytes).first(bytes.size() / 2)),
               common::Error);
  bytes[bytes.size() / 2] ^= 1;
  EXPECT_THROW(LevelGrids::restore(GridSlamConfig{}, bytes), common::Error);
  const auto grid = grids_.present().serialise();
  for (const auto& levels : std::vector<std::vector<std::int32_t>>{{}, {1}, {-1}, {0, 0}, {0, 64}}) {
    common::ByteWriter out;
    out.put(common::Magic{'R', 'B', 'L', 'L', 'E', 'V', 'L', '1'});
    out.put(std::int32_t{0});
    out.put(static_cast<std::uint64_t>(levels.size()));
    for (const std::int32_t level : levels) {
      out.put(level);
      out.put(0.0);
      out.put(static_cast<std::uint64_t>(grid.size()));
      out.putAll(std::span(grid));
    }
    EXPECT_THROW(LevelGrids::restore(GridSlamConfig{}, std::move(out).sealed()), common::Error);
  }
}

}  // namespace
}  // namespace rubble::slam_lidar
