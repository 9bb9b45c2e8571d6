#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace rubble::common {

/// Angle folded into (-pi, pi].
double wrapAngle(double angle);

/// Planar rigid transform, metres and radians. `T_a_b` maps coordinates of frame b to frame a.
struct Pose2 {
  double x = 0.0;
  double y = 0.0;
  double yaw = 0.0;

  /// T_a_c = T_a_b * T_b_c; the yaw is wrapped.
  Pose2 operator*(const Pose2& T_b_c) const;
  Pose2 inverse() const;
  /// p_a = T_a_b * p_b.
  Eigen::Vector2d operator*(const Eigen::Vector2d& p_b) const;
  Eigen::Vector2d translation() const { return {x, y}; }
};

/// Spatial rigid transform, metres. `T_a_b` maps coordinates of frame b to frame a.
using Pose3 = Eigen::Isometry3d;

/// Roll, pitch, yaw in radians, Z-Y-X order: R = Rz(yaw) Ry(pitch) Rx(roll).
struct RollPitchYaw {
  double roll = 0.0;
  double pitch = 0.0;
  double yaw = 0.0;
};

Eigen::Matrix3d rotationFromRpy(const RollPitchYaw& rpy);

/// Inverse of rotationFromRpy for |pitch| < pi/2; at the pole yaw is put to zero.
RollPitchYaw rpyFromRotation(const Eigen::Matrix3d& R);

/// The planar part lifted to 3D at height z, level.
Pose3 pose3FromPose2(const Pose2& T, double z = 0.0);

}  // namespace rubble::common
