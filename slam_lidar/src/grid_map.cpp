#include "grid_map.h"

namespace rubble::slam_lidar {

GridMap::GridMap(const GridSlamConfig& config) : writer_(config) {
  double cell_size = config.map.cell_size;
  for (int i = 0; i < config.map.levels; ++i, cell_size *= 2.0) {
    levels_.emplace_back(cell_size, config.scan.max_range);
  }
}

void GridMap::recentre(const Eigen::Vector2d& p_world) {
  for (TiledGrid& level : levels_) {
    level.recentre(p_world);
  }
}

void GridMap::write(const common::Pose2& T_world_lidar, std::span<const RayEnd> rays) {
  ++revision_;
  recentre(T_world_lidar.translation());
  for (TiledGrid& level : levels_) {
    writer_.write(level, T_world_lidar, rays, revision_);
  }
}

void GridMap::save(common::ByteWriter& out) const {
  out.put(revision_);
  out.put(static_cast<std::uint64_t>(levels_.size()));
  for (const TiledGrid& level : levels_) {
    level.save(out);
  }
}

void GridMap::load(common::ByteReader& in) {
  revision_ = in.get<std::uint64_t>();
  if (in.get<std::uint64_t>() != levels_.size()) {
    in.fail("its map has another number of levels than the configuration");
  }
  for (TiledGrid& level : levels_) {
    level.load(in);
  }
}

}  // namespace rubble::slam_lidar
