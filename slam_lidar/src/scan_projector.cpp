#include "scan_projector.h"

#include <algorithm>
#include <cmath>

namespace rubble::slam_lidar {
namespace {

/// exp of a planar twist (x, y, yaw).
common::Pose2 expSe2(const Eigen::Vector3d& xi) {
  const double yaw = xi.z();
  const bool straight = std::abs(yaw) < 1e-9;
  const double a = straight ? 1.0 : std::sin(yaw) / yaw;
  const double b = straight ? 0.5 * yaw : (1.0 - std::cos(yaw)) / yaw;
  return {a * xi.x() - b * xi.y(), b * xi.x() + a * xi.y(), yaw};
}

/// R_level_lidar * (d, 0) for a direction d in the LiDAR's plane; R = Ry(pitch) Rx(roll).
Eigen::Vector3d levelled(const Eigen::Vector2d& d, double roll, double pitch) {
  const double across = std::sin(roll) * d.y();
  return {std::cos(pitch) * d.x() + std::sin(pitch) * across, std::cos(roll) * d.y(),
          std::cos(pitch) * across - std::sin(pitch) * d.x()};
}

}  // namespace

void ScanProjector::updateDirections(const LidarScan& scan) {
  if (directions_.size() == scan.ranges.size() && first_angle_ == scan.first_angle &&
      angle_step_ == scan.angle_step) {
    return;
  }
  first_angle_ = scan.first_angle;
  angle_step_ = scan.angle_step;
  directions_.resize(scan.ranges.size());
  for (std::size_t i = 0; i < directions_.size(); ++i) {
    const double angle = first_angle_ + static_cast<double>(i) * angle_step_;
    directions_[i] = {std::cos(angle), std::sin(angle)};
  }
}

void ScanProjector::project(const LidarScan& scan, const Attitude& first, const Attitude& last, double height,
                            const Eigen::Vector3d& twist, ProjectedScan& out) {
  updateDirections(scan);
  out.rays.clear();
  out.points.clear();
  const std::size_t n = scan.ranges.size();
  const bool tilted = first.roll != 0.0 || first.pitch != 0.0 || last.roll != 0.0 || last.pitch != 0.0;
  const bool moving = config_.sweep_duration > 0.0 && !twist.isZero(0.0);
  const common::Pose2 T_beam_next =
      moving ? expSe2(twist * (config_.sweep_duration / static_cast<double>(n))) : common::Pose2{};
  common::Pose2 T_first_beam;

  for (std::size_t i = 0; i < n; ++i, T_first_beam = moving ? T_first_beam * T_beam_next : T_first_beam) {
    const double range = static_cast<double>(scan.ranges[i]);
    if (!(range >= config_.min_range && range < config_.max_range)) {
      continue;
    }
    Eigen::Vector2d p = range * directions_[i];
    bool in_slice = std::abs(height) <= config_.slice;
    if (tilted) {
      const double t = n > 1 ? static_cast<double>(i) / static_cast<double>(n - 1) : 0.0;
      const Eigen::Vector3d p_level = range * levelled(directions_[i], std::lerp(first.roll, last.roll, t),
                                                       std::lerp(first.pitch, last.pitch, t));
      if (p_level.z() < config_.height_margin - config_.height_above_floor ||
          p_level.z() > config_.height_below_ceiling - config_.height_margin) {
        continue;
      }
      p = p_level.head<2>();
      in_slice = std::abs(p_level.z() + height) <= config_.slice;
    }
    if (moving) {
      p = T_first_beam * p;
    }
    const auto x = static_cast<float>(p.x());
    const auto y = static_cast<float>(p.y());
    out.points.add(x, y, 1.0F);
    if (in_slice) {
      out.rays.push_back({x, y, true});
    }
  }
  out.points.pad();
}

}  // namespace rubble::slam_lidar
