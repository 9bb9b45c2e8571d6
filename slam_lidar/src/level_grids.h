#pragma once

#include <cstdint>
#include <map>
#include <rubble/grid_map_t.hpp>
#include <span>
#include <vector>

#include "common/time.h"
#include "map_publisher.h"
#include "slam_lidar/grid_slam.h"

namespace rubble::slam_lidar {

/// A grid for every level; the LiDAR is on one of them, and only that one changes.
class LevelGrids {
 public:
  /// Levels beyond this many are damage.
  static constexpr std::int32_t kMostLevels = 64;

  /// Level 0, where the LiDAR is at `T_world_lidar`.
  LevelGrids(const GridSlamConfig& config, const common::Pose2& T_world_lidar);

  std::int32_t level() const { return level_; }
  GridSlam& present() { return at(level_).grid; }
  const GridSlam& present() const { return levels_.at(level_).grid; }
  /// m, over level 0's.
  double floor() const { return levels_.at(level_).floor; }
  bool knows(std::int32_t level) const { return levels_.contains(level); }

  /// Goes on in the grid of a level that is known, at the pose of the present one.
  void enter(std::int32_t level);
  /// The same in a new grid, which the next scan begins at `T_world_lidar`, on a floor at this height (m).
  void begin(std::int32_t level, const common::Pose2& T_world_lidar, double floor);

  /// The next message of the present level, and of one of the others, in turn, for late joiners.
  std::vector<rubble::grid_map_t> nextMaps(common::Utime utime);
  /// All that was not sent yet.
  std::vector<rubble::grid_map_t> remainingMaps(common::Utime utime);

  std::vector<std::uint8_t> serialise() const;
  /// Throws common::Error for bytes that are truncated, corrupt, of another version, or of another map
  /// geometry.
  static LevelGrids restore(const GridSlamConfig& config, std::span<const std::uint8_t> bytes);

 private:
  struct Level {
    GridSlam grid;
    double floor = 0.0;
    MapPublisher publisher{};
    std::vector<std::uint8_t> left{};  ///< the grid as it was when the LiDAR left it
  };

  explicit LevelGrids(const GridSlamConfig& config) : config_(config) {}
  Level& at(std::int32_t level) { return levels_.at(level); }
  /// Scans that wait for confirmation were not meant for good.
  void leave();

  GridSlamConfig config_;
  std::map<std::int32_t, Level> levels_;
  std::int32_t level_ = 0;
  std::int32_t repeated_ = 0;  // Of the other levels, the one whose map was sent last.
};

}  // namespace rubble::slam_lidar
