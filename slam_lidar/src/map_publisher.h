#pragma once

#include <map>
#include <rubble/grid_map_t.hpp>
#include <utility>

#include "common/time.h"
#include "slam_lidar/grid_slam.h"

namespace rubble::slam_lidar {

/// Cuts the map into GRID_MAP messages: changed tiles first, then those sent longest ago.
class MapPublisher {
 public:
  /// The next message, at most about 60 kB.
  rubble::grid_map_t next(const GridSlam& grid, common::Utime utime, std::int32_t level);

  /// True while some tile's newest revision has not been sent.
  bool behind(const GridSlam& grid) const;

 private:
  struct Sent {
    std::int64_t revision = -1;
    std::int64_t message = -1;
  };

  std::map<std::pair<std::int32_t, std::int32_t>, Sent> sent_;
  std::int64_t messages_ = 0;
};

}  // namespace rubble::slam_lidar
