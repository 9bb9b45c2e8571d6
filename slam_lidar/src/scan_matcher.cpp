#include "scan_matcher.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace rubble::slam_lidar {
namespace {

constexpr double kFullOverlap = 0.3;
constexpr double kUnobservableSigma = 1.0;  // metres
constexpr double kBeamsErringTogether = 4.0;
/// Share of the beams by which another pose has to be better to be believed before the predicted one.
constexpr double kMargin = 0.1;
/// What the border of a search window costs against its centre.
constexpr double kSlope = 0.1;
constexpr std::size_t kCandidates = 6;

}  // namespace

double matchScore(const MatchSums& sums, double total_weight) {
  return sums.agree / std::max({sums.agree + sums.contradict, kFullOverlap * total_weight, 1e-9});
}

Eigen::Matrix3d matchCovariance(const MatchSums& sums, double total_weight, double cell_size) {
  // Yaw in units of an arc, so that one threshold fits all three.
  const double arc = std::sqrt(std::max(sums.H(2, 2), 1e-9) / std::max(sums.H(0, 0) + sums.H(1, 1), 1e-9));
  const Eigen::Vector3d unit(1.0, 1.0, 1.0 / std::max(arc, 0.1));
  const Eigen::Matrix3d H = unit.asDiagonal() * sums.H * unit.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(H);
  const double variance = kBeamsErringTogether * sums.cost / std::max(total_weight, 1e-9);
  const double noise = 0.01 * total_weight * 0.25 / (cell_size * cell_size);
  const Eigen::Vector3d information = (eigen.eigenvalues().array() - noise).max(0.0) / variance +
                                      1.0 / (kUnobservableSigma * kUnobservableSigma);
  const Eigen::Matrix3d covariance =
      eigen.eigenvectors() * information.cwiseInverse().asDiagonal() * eigen.eigenvectors().transpose();
  return unit.asDiagonal() * covariance * unit.asDiagonal();
}

ScanMatch ScanMatcher::align(std::span<const TiledGrid> levels, const PointSet& points,
                             const common::Pose2& seed) const {
  ScanMatch result;
  result.match = alignScan(levels, points, seed, config_.match.max_iterations);
  result.score = matchScore(result.match.sums, points.totalWeight());
  return result;
}

ScanMatch ScanMatcher::search(std::span<const TiledGrid> levels, const PointSet& points,
                              const SearchWindow& window) {
  ScanMatch best;
  best.match.T_world_lidar = window.T_world_centre;
  double best_value = -1e300;
  for (const SearchCandidate& candidate :
       correlative_.search(levels.back(), points, window, kSlope, kCandidates)) {
    ScanMatch m = align(levels, points, candidate.T_world_lidar);
    const common::Pose2 off = window.T_world_centre.inverse() * m.match.T_world_lidar;
    const double value =
        m.match.sums.quality() / points.totalWeight() -
        kSlope * std::hypot(std::hypot(off.x, off.y) / window.distance, off.yaw / window.angle);
    if (value > best_value) {
      best_value = value;
      best = m;
    }
  }
  return best;
}

ScanMatch ScanMatcher::track(std::span<const TiledGrid> levels, const PointSet& points,
                             std::span<const common::Pose2> seeds, const SearchWindow& window,
                             double expected_score) {
  ScanMatch best = align(levels, points, seeds.front());
  const double margin = kMargin * points.totalWeight();
  for (const common::Pose2& seed : seeds.subspan(1)) {
    if (best.score >= expected_score) {
      return best;
    }
    const ScanMatch other = align(levels, points, seed);
    if (other.match.sums.quality() > best.match.sums.quality() + margin) {
      best = other;
    }
  }
  if (best.score < expected_score) {
    const ScanMatch found = search(levels, points, window);
    if (found.match.sums.quality() > best.match.sums.quality() + margin) {
      best = found;
    }
    best.search = SearchKind::kLocal;
  }
  return best;
}

}  // namespace rubble::slam_lidar
