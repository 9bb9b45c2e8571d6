#pragma once

#include <Eigen/Core>

namespace rubble::fusion {

/// A floor with a grid of its own. The robot starts on level 0, whose grid is world. Another one begins where
/// the pose says that the robot is, and is off by as much as that was then.
struct Level {
  double floor = 0.0;                                ///< m, height in world
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();  ///< m, world: where its grid began
  /// Of (x, y, z m; heading rad) there.
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();
};

/// Of a pose's (x, y, z, heading) at `p` (m, world), by the level alone.
inline Eigen::Matrix4d levelCovariance(const Level& level, const Eigen::Vector2d& p) {
  Eigen::Matrix4d J = Eigen::Matrix4d::Identity();
  J(0, 3) = level.origin.y() - p.y();
  J(1, 3) = p.x() - level.origin.x();
  return J * level.covariance * J.transpose();
}

}  // namespace rubble::fusion
