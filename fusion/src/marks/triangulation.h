#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "marks/sighting.h"

namespace rubble::fusion {

/// Of a bearing (rad): the picture's corners and the published attitude.
inline constexpr double kCornerSigma = 0.01;

/// A bearing to an object, in world.
struct MarkView {
  Eigen::Vector3d p_world_camera = Eigen::Vector3d::Zero();
  Eigen::Vector3d d_world = Eigen::Vector3d::UnitX();  ///< unit vector
  double range = 0.0;                                  ///< m
  double range_sigma = 0.0;                            ///< m; 0: no range
  double bearing_sigma = kCornerSigma;  ///< rad; more where corners are not always the same points
};

struct MarkPosition {
  Eigen::Vector3d p_world = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();  ///< m^2
};

/// Deviation in the direction in which the place is known worst.
double largestSigma(const Eigen::Matrix3d& covariance);

/// Robust least squares (Gauss-Newton, Huber) over bearings and ranges, at least one view. Where nothing
/// tells the distance it is some metres, and the covariance says so.
MarkPosition triangulate(std::span<const MarkView> views);

}  // namespace rubble::fusion
