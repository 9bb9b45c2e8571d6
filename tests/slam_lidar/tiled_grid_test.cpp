#include "tiled_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>

#include "grid_map.h"
#include "synthetic_room.h"

namespace rubble::slam_lidar {
namespace {

std::uint8_t byteAt(const TiledGrid& grid, std::int64_t x, std::int64_t y) {
  const auto floorDiv = [](std::int64_t a) { return static_cast<std::int32_t>(a >> kTileShift); };
  const auto tile = grid.tiles().find({floorDiv(y), floorDiv(x)});
  if (tile == grid.tiles().end()) {
    return 128;
  }
  const auto cells = grid.tileCells(tile->second);
  return TiledGrid::occupancyByte(
      cells[static_cast<std::size_t>((y & kTileMask) * kTileSide + (x & kTileMask))].log_odds);
}

/// Every quad of every tile holds the bytes of its four cells, across tile borders too.
void expectQuadsAreConsistent(const TiledGrid& grid) {
  const GridView view = grid.view();
  for (const auto& [key, slot] : grid.tiles()) {
    for (int i = 0; i < kTileArea; ++i) {
      const std::int64_t x = std::int64_t{key.second} * kTileSide + i % kTileSide;
      const std::int64_t y = std::int64_t{key.first} * kTileSide + i / kTileSide;
      const std::uint32_t quad = view.quads[slot * kTileArea + i];
      const auto expected = static_cast<std::uint32_t>(byteAt(grid, x, y)) |
                            static_cast<std::uint32_t>(byteAt(grid, x + 1, y)) << 8 |
                            static_cast<std::uint32_t>(byteAt(grid, x, y + 1)) << 16 |
                            static_cast<std::uint32_t>(byteAt(grid, x + 1, y + 1)) << 24;
      ASSERT_EQ(quad, expected) << x << ", " << y;
    }
  }
}

TEST(TiledGrid, QuadsFollowTheCellsAcrossTileBordersAndNegativeCoordinates) {
  TiledGrid grid(0.05, 10.0);
  std::mt19937 random(1);
  const int centre = (1 << grid.view().window_tiles_log2) / 2 * kTileSide;
  for (std::uint64_t scan = 1; scan <= 20; ++scan) {
    grid.beginScan(scan);
    for (int i = 0; i < 300; ++i) {
      const int x = centre + static_cast<int>(random() % 100) - 50;
      const int y = centre + static_cast<int>(random() % 100) - 50;
      grid.addEvidence(x, y, random() % 2 == 0 ? 200 : -50, 1500);
    }
  }
  expectQuadsAreConsistent(grid);
}

TEST(TiledGrid, ACellTakesEvidenceOncePerScanAndStaysWithinItsLimit) {
  TiledGrid grid(0.05, 10.0);
  const int c = (1 << grid.view().window_tiles_log2) / 2 * kTileSide;
  grid.beginScan(1);
  grid.addEvidence(c, c, 200, 500);
  grid.addEvidence(c, c, -50, 500);
  const auto logOdds = [&] { return grid.tileCells(grid.tiles().at({0, 0})).front().log_odds; };
  EXPECT_EQ(logOdds(), 200);
  for (std::uint64_t scan = 2; scan < 10; ++scan) {
    grid.beginScan(scan);
    grid.addEvidence(c, c, 200, 500);
  }
  EXPECT_EQ(logOdds(), 500);
  EXPECT_EQ(grid.tileRevision(grid.tiles().at({0, 0})), 3U) << "the last revision in which it changed";
}

/// The map of one scan, brute force: all beams, a set of cells, hits win.
TEST(GridMap, EqualsABruteForceMapWhereverTheRobotIs) {
  const SyntheticRoom room;
  const auto ranges = room.scan({});
  for (const common::Pose2& T : {common::Pose2{0.01, 0.02, 0.3}, common::Pose2{-7654.321, 9876.543, -2.0}}) {
    GridSlamConfig config;
    GridMap map(config);
    std::vector<RayEnd> rays;
    for (std::size_t i = 0; i < ranges.size(); ++i) {
      const double a = SyntheticRoom::kFirstAngle + static_cast<double>(i) * SyntheticRoom::kAngleStep;
      const auto r = static_cast<double>(ranges[i]);
      rays.push_back({static_cast<float>(r * std::cos(a)), static_cast<float>(r * std::sin(a)), true});
    }
    map.write(T, rays);
    const auto cellOf = [&](const Eigen::Vector2d& p) {
      return std::pair(static_cast<std::int64_t>(std::floor(p.y() / 0.05)),
                       static_cast<std::int64_t>(std::floor(p.x() / 0.05)));
    };
    std::map<std::pair<std::int64_t, std::int64_t>, bool> hits;
    Eigen::Vector2d previous(1e9, 1e9);
    for (const RayEnd& ray : rays) {
      const Eigen::Vector2d p(static_cast<double>(ray.x), static_cast<double>(ray.y));
      const double gap = (p - previous).norm();
      for (int k = 1; gap < 0.4 && k <= static_cast<int>(gap / 0.05); ++k) {
        hits[cellOf(
            T * Eigen::Vector2d(previous + (p - previous) * k / (static_cast<int>(gap / 0.05) + 1)))] = true;
      }
      hits[cellOf(T * p)] = true;
      previous = p;
    }
    const auto expected_hit = static_cast<int>(std::lround(
        kLogOddsScale * std::log(config.map.hit_probability / (1.0 - config.map.hit_probability))));
    std::size_t found = 0;
    for (const auto& [key, slot] : map.finest().tiles()) {
      const auto cells = map.finest().tileCells(slot);
      for (int i = 0; i < kTileArea; ++i) {
        const int log_odds = cells[static_cast<std::size_t>(i)].log_odds;
        const std::pair cell(std::int64_t{key.first} * kTileSide + i / kTileSide,
                             std::int64_t{key.second} * kTileSide + i % kTileSide);
        if (log_odds > 0) {
          ++found;
          EXPECT_EQ(log_odds, expected_hit);
          EXPECT_TRUE(hits.contains(cell));
        } else if (log_odds < 0) {
          // Free cells lie on some beam before its end.
          const Eigen::Vector2d p =
              T.inverse() * Eigen::Vector2d((static_cast<double>(cell.second) + 0.5) * 0.05,
                                            (static_cast<double>(cell.first) + 0.5) * 0.05);
          EXPECT_FALSE(hits.contains(cell)) << "a hit wins";
          EXPECT_TRUE(std::any_of(rays.begin(), rays.end(), [&p](const RayEnd& ray) {
            const Eigen::Vector2d end(static_cast<double>(ray.x), static_cast<double>(ray.y));
            const double t = std::clamp(p.dot(end) / end.squaredNorm(), 0.0, 1.0);
            return (p - t * end).norm() < 0.06;
          }));
        }
      }
    }
    EXPECT_EQ(found, hits.size());
    EXPECT_LT(map.finest().tiles().size(), 100U);
    for (const TiledGrid& level : map.levels()) {
      expectQuadsAreConsistent(level);
    }
  }
}

TEST(TiledGrid, SaveAndLoadKeepsEverything) {
  GridSlamConfig config;
  GridMap map(config);
  map.write({-3.0, 2.0, 0.1}, std::vector<RayEnd>{{2.0F, 1.0F, true}, {1.0F, -3.0F, true}});
  common::ByteWriter out;
  map.save(out);
  GridMap copy(config);
  common::ByteReader in(out.bytes(), "grid");
  copy.load(in);
  EXPECT_EQ(in.left(), 0U);
  for (std::size_t i = 0; i < map.levels().size(); ++i) {
    expectQuadsAreConsistent(copy.levels()[i]);
  }
  common::ByteWriter again;
  copy.save(again);
  EXPECT_EQ(out.bytes(), again.bytes());
}

}  // namespace
}  // namespace rubble::slam_lidar
