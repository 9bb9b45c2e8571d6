#pragma once

#include <Eigen/Core>

#include "common/geometry.h"
#include "rotation_vector.h"

namespace rubble::fusion {

/// What the joint estimator knows of one moment.
struct JointState {
  common::Pose3 T_world_camera = common::Pose3::Identity();
  double log_scale = 0.0;  ///< of the metres per unit of the monocular map
  double clock = 0.0;      ///< s that the LiDAR's stamps are behind the camera's
};

/// Change of a state: position in world (m), rotation vector in world, applied from the left (rad), logarithm
/// of the scale, clock (s).
inline constexpr int kJointSize = 8;
using JointVector = Eigen::Matrix<double, kJointSize, 1>;
using JointMatrix = Eigen::Matrix<double, kJointSize, kJointSize>;

inline JointState perturbed(const JointState& state, const JointVector& delta) {
  JointState result = state;
  result.T_world_camera.translation() += delta.head<3>();
  // Normalised: what is not quite a rotation would grow from state to state.
  const Eigen::Quaterniond q(rotationFromVector(delta.segment<3>(3)) * state.T_world_camera.linear());
  result.T_world_camera.linear() = q.normalized().toRotationMatrix();
  result.log_scale += delta(6);
  result.clock += delta(7);
  return result;
}

}  // namespace rubble::fusion
