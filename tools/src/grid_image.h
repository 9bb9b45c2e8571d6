#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <rubble/grid_map_t.hpp>
#include <rubble/object_t.hpp>
#include <span>
#include <utility>
#include <vector>

#include "common/trajectory.h"

namespace rubble::tools {

/// A level's grid put together from GRID_MAP messages.
class GridAssembly {
 public:
  /// Throws common::Error for a tile that cannot be unpacked or does not fit what came before.
  void add(const rubble::grid_map_t& message);

  bool empty() const { return tiles_.empty(); }

  /// Writes `stem`.pgm and `stem`.yaml as ROS' map_server reads them (white free, black occupied, grey
  /// unknown; image row 0 is the largest y), and `stem`.png with the LiDAR's path drawn in purple, the
  /// robot's in green and confirmed marks with their ids (victims red, hazards orange, codes blue); where
  /// there is a path of the robot, its front view (x, z) stands below.
  void write(const std::filesystem::path& stem, const common::Trajectory& T_world_lidar,
             const common::Trajectory& T_world_body, std::span<const rubble::object_t> objects) const;

 private:
  struct Tile {
    std::int64_t revision = -1;
    std::vector<std::uint8_t> cells;
  };

  double cell_size_ = 0.0;
  std::int32_t tile_cells_ = 0;
  std::map<std::pair<std::int32_t, std::int32_t>, Tile> tiles_;
};

}  // namespace rubble::tools
