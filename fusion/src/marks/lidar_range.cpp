#include "marks/lidar_range.h"

#include <cmath>
#include <limits>

namespace rubble::fusion {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// Beams that end this near the bearing's vertical plane (m, and as an angle) lie in it.
constexpr double kBeside = 0.02;
constexpr double kBesideAngle = 0.01;
constexpr double kNearest = 0.2;
/// Bearings steeper than this say nothing about what stands below them (sine).
constexpr double kSteepest = 0.7;
/// Beyond this way from the scan's plane (m) there may be anything.
constexpr double kFarthestPlane = 1.5;
constexpr double kSigma = 0.04;
constexpr double kSigmaPerHeight = 0.5;

}  // namespace

std::optional<RangeMeasurement> rangeAlong(const Vector3d& p_world_camera, const Vector3d& d_world,
                                           const RangeScan& scan, const common::Pose3& T_world_lidar) {
  const double level = d_world.head<2>().norm();
  if (std::abs(d_world.z()) > kSteepest) {
    return std::nullopt;
  }
  const Vector2d forward = d_world.head<2>() / level;
  double nearest = std::numeric_limits<double>::infinity();
  double height = 0.0;
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    const double range = static_cast<double>(scan.ranges[i]);
    if (!std::isfinite(range) || range <= 0.0) {
      continue;
    }
    const double angle = scan.first_angle + static_cast<double>(i) * scan.angle_step;
    const Vector3d p = T_world_lidar * Vector3d(range * std::cos(angle), range * std::sin(angle), 0.0);
    const Vector2d v = (p - p_world_camera).head<2>();
    const double along = v.dot(forward);
    const double beside = std::abs(v.x() * forward.y() - v.y() * forward.x());
    if (along > kNearest && beside < kBeside + kBesideAngle * along && along < nearest) {
      nearest = along;
      height = p.z();
    }
  }
  if (!std::isfinite(nearest)) {
    return std::nullopt;
  }
  const double range = nearest / level;
  const double off_plane = std::abs(p_world_camera.z() + range * d_world.z() - height);
  if (off_plane > kFarthestPlane) {
    return std::nullopt;
  }
  return RangeMeasurement{range, (kSigma + kSigmaPerHeight * off_plane) / level};
}

}  // namespace rubble::fusion
