#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <deque>
#include <utility>

#include "common/time.h"

namespace rubble::fusion {

/// Whether vision turns as the LiDAR does. On a level plane a scan tells heading better than anything, a
/// slope ahead or not; a camera that turns on the spot may take new points for old ones and go astray.
class TurnCheck {
 public:
  /// A tracked picture. `map_revision`: of that map; in another one turns are counted anew, from the
  /// LiDAR's attitude as it is taken to be, R_world_lidar.
  void addVision(common::Utime utime, std::int32_t map_id, std::int64_t map_revision,
                 const Eigen::Matrix3d& R_mono_lidar, const Eigen::Matrix3d& R_world_lidar);
  /// Heading (rad) of a scan that was matched on a usable plane.
  void addLidar(common::Utime utime, double heading);

  /// Vision is not to be believed.
  bool astray() const { return astray_; }

 private:
  using Headings = std::deque<std::pair<common::Utime, double>>;  // Whole turns are counted.

  static void add(Headings& headings, common::Utime utime, double heading);
  void compare();

  std::int32_t map_id_ = 0;
  std::int64_t map_revision_ = -1;
  Eigen::Matrix3d R_world_mono_ = Eigen::Matrix3d::Identity();
  Headings vision_;
  Headings lidar_;
  int apart_ = 0;     // Comparisons in a row.
  int together_ = 0;  // The same.
  bool astray_ = false;
};

}  // namespace rubble::fusion
