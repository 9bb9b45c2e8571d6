#include "level_grids.h"

#include <cmath>
#include <utility>

#include "common/byte_stream.h"
#include "common/error.h"

namespace rubble::slam_lidar {

namespace {

constexpr common::Magic kMagic = {'R', 'B', 'L', 'L', 'E', 'V', 'L', '1'};
/// Search window (m, rad) around the present pose on a level that the LiDAR comes to: vision has carried it.
constexpr double kEnterDistance = 1.0;
constexpr double kEnterAngle = 0.3;

}  // namespace

LevelGrids::LevelGrids(const GridSlamConfig& config, const common::Pose2& T_world_lidar) : config_(config) {
  levels_.emplace(0, Level{GridSlam(config, T_world_lidar)});
}

void LevelGrids::leave() {
  Level& level = at(level_);
  level.grid.discardPending(0);
  level.left = level.grid.serialise();
}

void LevelGrids::enter(std::int32_t level) {
  RUBBLE_CHECK(knows(level));
  const common::Pose2 pose = present().pose();
  if (level != level_) {
    leave();
    level_ = level;
  }
  present().relocalise(pose, kEnterDistance, kEnterAngle);
}

void LevelGrids::begin(std::int32_t level, const common::Pose2& T_world_lidar, double floor) {
  RUBBLE_CHECK(!knows(level) && level < kMostLevels);
  leave();
  level_ = level;
  levels_.emplace(level, Level{GridSlam(config_, T_world_lidar), floor});
}

std::vector<rubble::grid_map_t> LevelGrids::nextMaps(common::Utime utime) {
  std::vector<rubble::grid_map_t> maps{at(level_).publisher.next(present(), utime, level_)};
  if (levels_.size() > 1) {
    const auto after = [&](std::int32_t level) {
      const auto next = levels_.upper_bound(level);
      return next == levels_.end() ? levels_.begin()->first : next->first;
    };
    repeated_ = after(repeated_) == level_ ? after(level_) : after(repeated_);
    maps.push_back(at(repeated_).publisher.next(at(repeated_).grid, utime, repeated_));
  }
  return maps;
}

std::vector<rubble::grid_map_t> LevelGrids::remainingMaps(common::Utime utime) {
  std::vector<rubble::grid_map_t> maps;
  for (auto& [id, level] : levels_) {
    while (level.publisher.behind(level.grid)) {
      maps.push_back(level.publisher.next(level.grid, utime, id));
    }
  }
  return maps;
}

std::vector<std::uint8_t> LevelGrids::serialise() const {
  common::ByteWriter out;
  out.put(kMagic);
  out.put(level_);
  out.put(static_cast<std::uint64_t>(levels_.size()));
  for (const auto& [id, level] : levels_) {
    const std::vector<std::uint8_t> grid = id == level_ ? level.grid.serialise() : level.left;
    out.put(id);
    out.put(level.floor);
    out.put(static_cast<std::uint64_t>(grid.size()));
    out.putAll(std::span(grid));
  }
  return std::move(out).sealed();
}

LevelGrids LevelGrids::restore(const GridSlamConfig& config, std::span<const std::uint8_t> bytes) {
  common::ByteReader in(bytes, "LiDAR SLAM levels");
  in.openSealed(kMagic, "a state");
  LevelGrids grids(config);
  grids.level_ = in.get<std::int32_t>();
  for (std::size_t i = in.getCount(sizeof(std::int32_t) + sizeof(double) + sizeof(std::uint64_t)); i > 0;
       --i) {
    const auto id = in.get<std::int32_t>();
    if (id < 0 || id >= kMostLevels || grids.knows(id)) {
      in.fail("an impossible level");
    }
    const auto floor = in.get<double>();
    if (!std::isfinite(floor)) {
      in.fail("a floor that is not finite");
    }
    std::vector<std::uint8_t> grid(in.getCount(1));
    in.getAll(std::span(grid));
    Level level{GridSlam::restore(config, grid), floor};
    level.left = std::move(grid);
    grids.levels_.emplace(id, std::move(level));
  }
  if (!grids.knows(grids.level_)) {
    in.fail("without the level that the LiDAR is on");
  }
  if (in.left() != 0) {
    in.fail("there is more than belongs to it");
  }
  return grids;
}

}  // namespace rubble::slam_lidar
