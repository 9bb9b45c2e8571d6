#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "common/geometry.h"
#include "geometry/ray_pair.h"
#include "slam_mono/camera.h"

namespace rubble::slam_mono {

/// What RANSAC found; score as in Mur-Artal et al. 2015, section IV.
struct TwoViewModel {
  Eigen::Matrix3d M = Eigen::Matrix3d::Zero();
  double score = 0.0;
  int inliers = 0;
};

TwoViewModel findRotation(const Camera& camera, std::span<const RayPair> pairs, int iterations,
                          std::uint64_t seed);
TwoViewModel findHomography(const Camera& camera, std::span<const RayPair> pairs, int iterations,
                            std::uint64_t seed);
TwoViewModel findEssential(std::span<const RayPair> pairs, int iterations, std::uint64_t seed);

/// All motions that a model allows, whatever side of the cameras the points come to lie on; |translation|
/// = 1.
std::vector<common::Pose3> motionsOfEssential(const Eigen::Matrix3d& E);
std::vector<common::Pose3> motionsOfHomography(const Eigen::Matrix3d& H);

}  // namespace rubble::slam_mono
