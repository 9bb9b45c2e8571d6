#pragma once

#include <span>
#include <vector>

#include "common/byte_stream.h"
#include "scan_writer.h"

namespace rubble::slam_lidar {

/// All resolutions of the map (Kohlbrecher et al. 2011, IV-C), written together.
class GridMap {
 public:
  explicit GridMap(const GridSlamConfig& config);

  /// Makes the surroundings of p fast to reach; to be called before matching there.
  void recentre(const Eigen::Vector2d& p_world);
  void write(const common::Pose2& T_world_lidar, std::span<const RayEnd> rays);

  std::span<const TiledGrid> levels() const { return levels_; }
  const TiledGrid& finest() const { return levels_.front(); }
  std::uint64_t revision() const { return revision_; }
  bool empty() const { return revision_ == 0; }

  void save(common::ByteWriter& out) const;
  /// Into an empty map. Throws common::Error for another geometry.
  void load(common::ByteReader& in);

 private:
  std::vector<TiledGrid> levels_;
  ScanWriter writer_;
  std::uint64_t revision_ = 0;
};

}  // namespace rubble::slam_lidar
