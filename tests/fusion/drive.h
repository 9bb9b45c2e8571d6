#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "alignment.h"
#include "common/robot_config.h"
#include "common/time.h"

namespace rubble::fusion::test {

/// A robot with camera and LiDAR on a stabiliser, in the frames of docs/frames.md.
inline common::RobotConfig robot() {
  common::RobotConfig robot;
  robot.plate_translation = {0.10, 0.0, 0.25};
  robot.camera.translation = {0.12, 0.03, 0.22};
  return robot;
}

/// Where the body is after `way` metres: a winding path on a level floor.
inline common::Pose3 windingPath(double way) {
  const double yaw = 0.9 * std::sin(0.8 * way);
  // Integrated in small steps: the heading is along the path.
  Eigen::Vector2d p = Eigen::Vector2d::Zero();
  constexpr double kStep = 0.005;
  for (double s = 0.0; s < way; s += kStep) {
    const double heading = 0.9 * std::sin(0.8 * s);
    p += kStep * Eigen::Vector2d(std::cos(heading), std::sin(heading));
  }
  return common::pose3FromPose2({p.x(), p.y(), yaw});
}

/// The body pitched upwards by `angle` (rad) on the spot.
inline common::Pose3 pitchedUp(const common::Pose3& T_world_body, double angle) {
  common::Pose3 T = T_world_body;
  T.rotate(Eigen::AngleAxisd(-angle, Eigen::Vector3d::UnitY()));
  return T;
}

/// How the monocular map lies in world in these tests.
inline Similarity S_world_mono() {
  Similarity S;
  S.scale = 2.7;
  S.R = common::rotationFromRpy({-1.6, 0.1, -1.4});
  S.p = {0.3, -0.2, 0.25};
  return S;
}

inline common::Pose3 T_mono_camera(const common::Pose3& T_world_camera, const Similarity& S) {
  common::Pose3 T = common::Pose3::Identity();
  T.linear() = S.R.transpose() * T_world_camera.linear();
  T.translation() = S.R.transpose() * (T_world_camera.translation() - S.p) / S.scale;
  return T;
}

inline common::Pose2 level(const common::Pose3& T) {
  return {T.translation().x(), T.translation().y(), common::rpyFromRotation(T.linear()).yaw};
}

inline double angleBetween(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  return Eigen::AngleAxisd(Eigen::Matrix3d(a.transpose() * b)).angle();
}

}  // namespace rubble::fusion::test
