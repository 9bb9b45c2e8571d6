#pragma once

#include <zlib.h>

#include <map>
#include <memory>
#include <rubble/grid_map_t.hpp>
#include <utility>
#include <vector>

#include "common/time.h"
#include "slam_lidar/grid_slam.h"

namespace rubble::slam_lidar {

/// Cuts the map into GRID_MAP messages: changed tiles first, then older ones in turn.
class MapPublisher {
 public:
  MapPublisher();

  /// The next message, at most about 60 kB.
  rubble::grid_map_t next(const GridSlam& grid, common::Utime utime, std::int32_t level);

  /// True while some tile's newest revision has not been sent.
  bool behind(const GridSlam& grid) const;

 private:
  struct EndDeflate {
    void operator()(z_stream* stream) const;
  };

  bool changed(const TileInfo& tile) const;
  std::vector<std::uint8_t> compress(const std::vector<std::uint8_t>& cells);

  std::map<std::pair<std::int32_t, std::int32_t>, std::uint64_t> sent_revision_;
  std::size_t next_repeated_ = 0;
  std::unique_ptr<z_stream, EndDeflate> deflate_;
};

}  // namespace rubble::slam_lidar
