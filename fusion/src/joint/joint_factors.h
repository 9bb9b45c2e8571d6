#pragma once

#include <ceres/rotation.h>

#include "joint_state.h"

/// What the joint estimator minimises, as functors for automatic differentiation. Each takes the changes
/// (JointVector) of the states that it was made with, and gives residuals divided by their deviations.
namespace rubble::fusion {

template <typename T>
using Vector3 = Eigen::Matrix<T, 3, 1>;
template <typename T>
using Matrix3 = Eigen::Matrix<T, 3, 3>;

/// A state plus its change.
template <typename T>
struct ChangedState {
  ChangedState(const JointState& state, const T* delta)
      : p(state.T_world_camera.translation().cast<T>() + Eigen::Map<const Vector3<T>>(delta)),
        log_scale(state.log_scale + delta[6]),
        clock(state.clock + delta[7]) {
    Matrix3<T> turn;
    ceres::AngleAxisToRotationMatrix(delta + 3, turn.data());
    R = turn * state.T_world_camera.linear().cast<T>();
  }

  Vector3<T> p;
  Matrix3<T> R;
  T log_scale;
  T clock;
};

template <typename T>
Vector3<T> rotationVectorOf(const Matrix3<T>& R) {
  Vector3<T> v;
  ceres::RotationMatrixToAngleAxis(R.data(), v.data());
  return v;
}

/// Where the state was known to be.
struct PriorFactor {
  JointState state;  // The linearisation point.
  JointState mean;
  JointMatrix square_root;  // Of the information: upper triangular.

  template <typename T>
  bool operator()(const T* delta, T* residuals) const {
    const ChangedState<T> x(state, delta);
    Eigen::Matrix<T, kJointSize, 1> difference;
    difference << x.p - mean.T_world_camera.translation().cast<T>(),
        rotationVectorOf<T>(x.R * mean.T_world_camera.linear().transpose().cast<T>()),
        x.log_scale - mean.log_scale, x.clock - mean.clock;
    Eigen::Map<Eigen::Matrix<T, kJointSize, 1>>(residuals, kJointSize) = square_root.cast<T>() * difference;
    return true;
  }
};

/// Vision's motion between two states, with the scale as it walks.
struct MotionFactor {
  JointState from, to;
  common::Pose3 T_from_to;  // m, at log_scale
  double log_scale;
  double position_sigma, rotation_sigma, scale_sigma, clock_sigma;

  template <typename T>
  bool operator()(const T* delta_from, const T* delta_to, T* residuals) const {
    using std::exp;
    const ChangedState<T> a(from, delta_from);
    const ChangedState<T> b(to, delta_to);
    Eigen::Map<Eigen::Matrix<T, kJointSize, 1>> r(residuals);
    const T growth = exp(a.log_scale - log_scale);
    r.template head<3>() =
        (a.R.transpose() * (b.p - a.p) - growth * T_from_to.translation().cast<T>()) / T(position_sigma);
    r.template segment<3>(3) =
        rotationVectorOf<T>(T_from_to.linear().transpose().cast<T>() * a.R.transpose() * b.R) /
        T(rotation_sigma);
    r(6) = (b.log_scale - a.log_scale) / T(scale_sigma);
    r(7) = (b.clock - a.clock) / T(clock_sigma);
    return true;
  }
};

/// Grid SLAM's pose at a state's time by the LiDAR's clock.
struct LidarFactor {
  JointState state;
  common::Pose3 T_camera_lidar;
  common::Pose2 T_world_lidar;
  Eigen::Vector3d velocity;  // m/s, m/s, rad/s of the LiDAR in world
  Eigen::Matrix3d square_root;

  template <typename T>
  bool operator()(const T* delta, T* residuals) const {
    using std::atan2;
    const ChangedState<T> x(state, delta);
    const Vector3<T> p = x.p + x.R * T_camera_lidar.translation().cast<T>();
    const Vector3<T> forward = x.R * T_camera_lidar.linear().col(0).cast<T>();
    Vector3<T> r(p.x() - T_world_lidar.x, p.y() - T_world_lidar.y, atan2(forward.y(), forward.x()));
    r.z() -= T(T_world_lidar.yaw);
    // Whole turns carry no derivative.
    const double turn = common::wrapAngle(value(r.z())) - value(r.z());
    r.z() += T(turn);
    r += x.clock * velocity.cast<T>();
    Eigen::Map<Vector3<T>>(residuals, 3) = square_root.cast<T>() * r;
    return true;
  }

 private:
  static double value(double x) { return x; }
  template <typename T>
  static double value(const T& x) {
    return x.a;
  }
};

/// The body stands on its level's floor: height, then tilt about two axes.
struct FloorFactor {
  JointState state;
  common::Pose3 T_camera_body;
  double floor;  // m
  double height_sigma;

  template <typename T>
  bool operator()(const T* delta, T* residuals) const {
    const ChangedState<T> x(state, delta);
    residuals[0] = ((x.p + x.R * T_camera_body.translation().cast<T>()).z() - floor) / T(height_sigma);
    return true;
  }
};

struct LevelFactor {
  JointState state;
  common::Pose3 T_camera_body;
  double tilt_sigma;

  template <typename T>
  bool operator()(const T* delta, T* residuals) const {
    const ChangedState<T> x(state, delta);
    const Vector3<T> up = x.R * T_camera_body.linear().col(2).cast<T>();
    residuals[0] = up.x() / T(tilt_sigma);
    residuals[1] = up.y() / T(tilt_sigma);
    return true;
  }
};

/// The scale that the LiDAR's ranges at map points show.
struct ScaleFactor {
  JointState state;
  double log_scale;
  double sigma;

  template <typename T>
  bool operator()(const T* delta, T* residuals) const {
    residuals[0] = (state.log_scale + delta[6] - log_scale) / T(sigma);
    return true;
  }
};

}  // namespace rubble::fusion
