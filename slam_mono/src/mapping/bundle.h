#pragma once

#include <atomic>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "map/map.h"

namespace rubble::slam_mono {

/// A bundle adjustment as values, apart from the map: made from one map, solved anywhere, applied to a later
/// one.
struct BundleProblem {
  struct Residual {
    std::size_t keyframe = 0;  ///< index
    std::size_t point = 0;     ///< index
    Observation observation;
    Eigen::Vector2d pixel;
    double sigma = 1.0;  ///< pixels
  };
  std::vector<KeyframeId> keyframes;
  std::vector<common::Pose3> T_camera_mono;  ///< start, then result; same order
  std::vector<bool> fixed;                   ///< keyframes that don't move
  std::vector<PointId> points;
  std::vector<Eigen::Vector3d> p_mono_point;  ///< start, then result
  std::vector<Residual> residuals;
  std::vector<std::size_t> outliers;  ///< result: residuals beyond kChi2Two or behind the camera
};

/// The keyframes that move, the points that move with them, and `fixed` keyframes that hold them.
BundleProblem makeBundle(const Map& map, std::span<const KeyframeId> moving,
                         std::span<const KeyframeId> fixed, std::span<const PointId> points,
                         const OctaveScales& scales);

/// When to stop.
struct BundleEffort {
  int iterations = 5;
  double tolerance = 1e-4;  ///< relative decrease of the cost
};

/// Minimises the Huber-weighted reprojection error with Ceres, points eliminated by the Schur complement.
/// Deterministic, unless stopped from outside.
void solveBundle(const Camera& camera, BundleProblem& problem, const BundleEffort& effort,
                 const std::atomic<bool>* stop = nullptr);

/// Writes poses and points back, erases the outliers' observations, refreshes the points.
void applyBundle(Map& map, const BundleProblem& problem, const OctaveScales& scales);

}  // namespace rubble::slam_mono
