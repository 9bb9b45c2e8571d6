#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/geometry.h"
#include "slam_mono/camera.h"

namespace rubble::slam_mono {

/// The point where two bearings (unit vectors, each in its camera's frame) meet best, in frame a; linear in
/// the least squares sense of both directions. Empty when they are parallel to within 1e-6 rad or it lies
/// behind either camera.
std::optional<Eigen::Vector3d> triangulate(const common::Pose3& T_b_a, const Eigen::Vector3d& bearing_a,
                                           const Eigen::Vector3d& bearing_b);

/// One feature in two pictures.
struct TwoViewMatch {
  Eigen::Vector2d pixel_a;
  Eigen::Vector2d pixel_b;
  double sigma = 1.0;  ///< pixels, the larger of both
};

struct TwoViewConfig {
  int iterations = 200;           ///< RANSAC
  int min_points = 50;            ///< triangulated and good
  double min_inlier_share = 0.7;  ///< good points among the model's inliers
  double min_parallax = 0.017;    ///< rad, median over the good points, after the rotation is taken off
  double max_rival_share = 0.75;  ///< of the good points that the second best motion may have
  std::uint64_t seed = 1;
};

struct TwoViewResult {
  common::Pose3 T_b_a;                                   ///< |translation| = 1
  std::vector<std::optional<Eigen::Vector3d>> points_a;  ///< per match, in frame a; empty: no good point
  int point_count = 0;
  double parallax = 0.0;  ///< rad, median over the points
  bool planar = false;    ///< the homography was chosen
};

/// Relative pose and structure from two views of an unknown scene: homography and essential (fundamental)
/// matrix side by side in RANSAC, both scored (Mur-Artal et al. 2015, section IV), all motions that either
/// allows tried, the one with the most good points taken if it clearly wins. Good: in front of both cameras,
/// reprojected within kChi2Two in both pictures. Empty for pure rotation, too little parallax, an ambiguous
/// or badly supported result. The result is refined by minimising the reprojection error over pose and
/// points.
std::optional<TwoViewResult> reconstructTwoViews(const Camera& camera, std::span<const TwoViewMatch> matches,
                                                 const TwoViewConfig& config);

}  // namespace rubble::slam_mono
