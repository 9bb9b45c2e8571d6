#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <optional>

#include "common/geometry.h"
#include "marks/lidar_range.h"

namespace rubble::fusion {

/// The scale of a monocular map by the LiDAR's ranges at its points: whether the robot moves or stands, on
/// the level or off it. Where a map point lies near the plane of a scan, the range along its bearing over its
/// distance in the map is the scale.
class PointScale {
 public:
  /// A map point, new or moved (in units of the map).
  void set(std::int64_t id, std::int32_t map_id, const Eigen::Vector3d& p_mono);
  void erase(std::int64_t id) { points_.erase(id); }

  /// Logarithm of the scale (metres per unit) that most of the points before the camera agree on, looked for
  /// near `guess` where there is one; empty where too few do.
  std::optional<double> measure(std::int32_t map_id, const common::Pose3& T_mono_camera,
                                const common::Pose3& T_camera_lidar, const RangeScan& scan,
                                std::optional<double> guess) const;

 private:
  struct Point {
    std::int32_t map_id = 0;
    Eigen::Vector3d p_mono;
  };

  std::map<std::int64_t, Point> points_;
};

}  // namespace rubble::fusion
