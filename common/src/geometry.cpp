#include "common/geometry.h"

#include <cmath>
#include <numbers>

namespace rubble::common {

double wrapAngle(double angle) {
  const double wrapped = std::remainder(angle, 2.0 * std::numbers::pi);
  return wrapped <= -std::numbers::pi ? std::numbers::pi : wrapped;
}

Pose2 Pose2::operator*(const Pose2& T_b_c) const {
  const Eigen::Vector2d p = *this * T_b_c.translation();
  return {p.x(), p.y(), wrapAngle(yaw + T_b_c.yaw)};
}

Pose2 Pose2::inverse() const {
  const double c = std::cos(yaw);
  const double s = std::sin(yaw);
  return {-(c * x + s * y), s * x - c * y, wrapAngle(-yaw)};
}

Eigen::Vector2d Pose2::operator*(const Eigen::Vector2d& p_b) const {
  const double c = std::cos(yaw);
  const double s = std::sin(yaw);
  return {x + c * p_b.x() - s * p_b.y(), y + s * p_b.x() + c * p_b.y()};
}

Eigen::Matrix3d rotationFromRpy(const RollPitchYaw& rpy) {
  return (Eigen::AngleAxisd(rpy.yaw, Eigen::Vector3d::UnitZ()) *
          Eigen::AngleAxisd(rpy.pitch, Eigen::Vector3d::UnitY()) *
          Eigen::AngleAxisd(rpy.roll, Eigen::Vector3d::UnitX()))
      .toRotationMatrix();
}

RollPitchYaw rpyFromRotation(const Eigen::Matrix3d& R) {
  const double cos_pitch = std::hypot(R(0, 0), R(1, 0));
  const double pitch = std::atan2(-R(2, 0), cos_pitch);
  constexpr double kPole = 1e-9;
  if (cos_pitch < kPole) {
    return {std::atan2(-R(1, 2), R(1, 1)), pitch, 0.0};
  }
  return {std::atan2(R(2, 1), R(2, 2)), pitch, std::atan2(R(1, 0), R(0, 0))};
}

Pose3 pose3FromPose2(const Pose2& T, double z) {
  Pose3 T3 = Pose3::Identity();
  T3.linear() = rotationFromRpy({0.0, 0.0, T.yaw});
  T3.translation() = Eigen::Vector3d(T.x, T.y, z);
  return T3;
}

}  // namespace rubble::common
