#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace rubble::fusion {

/// Angles of the stabiliser (rad; T_body_plate: roll first, then pitch).
struct PlateAngles {
  double roll = 0.0;
  double pitch = 0.0;
};

/// The angles that make the plate level on a body of this attitude, within the servos' range (rad):
/// R_body_plate e_z = (sin p, -sin r cos p, cos r cos p) has to be the body's up.
inline PlateAngles levellingAngles(const Eigen::Matrix3d& R_world_body, double range) {
  const Eigen::Vector3d up = R_world_body.row(2);
  return {std::clamp(std::atan2(-up.y(), up.z()), -range, range),
          std::clamp(std::asin(std::clamp(up.x(), -1.0, 1.0)), -range, range)};
}

}  // namespace rubble::fusion
