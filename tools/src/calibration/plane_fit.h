#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/geometry.h"

namespace rubble::calibration {

/// Points of frame lidar (z = 0) that lie in a plane of frame camera: n^T (R p + t) = d.
struct PointsInPlane {
  Eigen::Vector3d normal;
  double distance = 0.0;
  std::vector<Eigen::Vector2d> points;
};

/// x and y in frame lidar as a point of space.
inline Eigen::Vector3d lifted(const Eigen::Vector2d& p) { return {p.x(), p.y(), 0.0}; }

struct PlaneFit {
  common::Pose3 T_camera_lidar = common::Pose3::Identity();
  /// Of a turn about the camera's axes (rad) and the shift along them (m), for residuals of deviation 1 m.
  Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Zero();
  std::vector<double> residuals;  // m
};

/// Least squares with Cauchy's loss. However many points a plane has, it weighs as two: their errors are
/// mostly the plane's.
PlaneFit fitPlanes(const std::vector<PointsInPlane>& planes, const common::Pose3& T_camera_lidar_start);

}  // namespace rubble::calibration
