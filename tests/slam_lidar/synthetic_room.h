#pragma once

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "slam_lidar/grid_slam.h"

namespace rubble::slam_lidar {

/// A room with corners and pillars, without any symmetry, and exact ranges in it.
class SyntheticRoom {
 public:
  static constexpr int kBeams = 361;
  static constexpr double kFirstAngle = -std::numbers::pi / 2.0;
  static constexpr double kAngleStep = std::numbers::pi / (kBeams - 1);

  /// Walls are askew to the grid by default: exactly along cell borders, noise-free hits all fall to one
  /// side.
  static constexpr common::Pose2 kAskew{0.013, 0.021, 0.1};

  explicit SyntheticRoom(const common::Pose2& T_world_start = {})
      : T_room_world_((T_world_start * kAskew).inverse()) {
    addLoop({{-4, -3}, {6, -3}, {6, 1}, {9, 1}, {9, 5}, {1, 5}, {1, 3.5}, {-4, 3.5}});
    addLoop({{3, 2}, {3.6, 2}, {3.6, 2.9}, {3, 2.9}});
    addLoop({{-2.5, -1.8}, {-2.0, -2.2}, {-1.8, -1.6}});
  }

  double range(const common::Pose2& T_world_lidar, double angle) const {
    const common::Pose2 T = T_room_world_ * T_world_lidar;
    const Eigen::Vector2d d(std::cos(T.yaw + angle), std::sin(T.yaw + angle));
    double nearest = std::numeric_limits<double>::infinity();
    for (const auto& [a, b] : walls_) {
      const Eigen::Vector2d e = b - a;
      const Eigen::Vector2d o = a - T.translation();
      const double cross = d.x() * e.y() - d.y() * e.x();
      if (std::abs(cross) < 1e-12) {
        continue;
      }
      const double t = (o.x() * e.y() - o.y() * e.x()) / cross;
      const double u = (o.x() * d.y() - o.y() * d.x()) / cross;
      if (t > 0.0 && u >= 0.0 && u <= 1.0) {
        nearest = std::min(nearest, t);
      }
    }
    return nearest;
  }

  std::vector<float> scan(const common::Pose2& T_world_lidar) const {
    std::vector<float> ranges(kBeams);
    for (int i = 0; i < kBeams; ++i) {
      ranges[static_cast<std::size_t>(i)] =
          static_cast<float>(range(T_world_lidar, kFirstAngle + i * kAngleStep));
    }
    return ranges;
  }

  static ScanInput input(common::Utime utime, std::span<const float> ranges) {
    ScanInput input;
    input.scan = {utime, kFirstAngle, kAngleStep, ranges};
    return input;
  }

 private:
  void addLoop(const std::vector<Eigen::Vector2d>& corners) {
    for (std::size_t i = 0; i < corners.size(); ++i) {
      walls_.emplace_back(corners[i], corners[(i + 1) % corners.size()]);
    }
  }

  common::Pose2 T_room_world_;
  std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>> walls_;
};

/// A drive through the room with turns of up to 12 degrees from scan to scan; pose 0 is the origin.
inline std::vector<common::Pose2> syntheticDrive(int scans) {
  std::vector<common::Pose2> poses;
  common::Pose2 T;
  for (int i = 0; i < scans; ++i) {
    poses.push_back(T);
    T = T * common::Pose2{0.05, 0.0, 0.2 * std::sin(0.21 * i)};
  }
  return poses;
}

inline double distance(const common::Pose2& a, const common::Pose2& b) {
  return (a.translation() - b.translation()).norm();
}

}  // namespace rubble::slam_lidar
