#pragma once

#include "correlative_search.h"
#include "gauss_newton.h"
#include "slam_lidar/grid_slam.h"

namespace rubble::slam_lidar {

struct ScanMatch {
  Match match;
  double score = 0.0;  ///< [0, 1], see matchScore()
  SearchKind search = SearchKind::kNone;
};

/// How much of what the scan and the map both know agrees: agree / (agree + contradict), less where they
/// share less than `kFullOverlap` of the beams.
double matchScore(const MatchSums& sums, double total_weight);

/// Covariance of (x, y, yaw): s^2 H^-1 at the finest level, where s^2 is the mean squared residual times the
/// number of neighbouring beams that err together. Information below what noise alone brings counts as none,
/// so along a bare corridor the variance grows to kUnobservableSigma^2.
Eigen::Matrix3d matchCovariance(const MatchSums& sums, double total_weight, double cell_size);

/// Gauss-Newton where it can be trusted, correlative search where not.
class ScanMatcher {
 public:
  explicit ScanMatcher(const GridSlamConfig& config) : config_(config) {}

  /// From the first seed; the others, then a search in `window`, are tried as long as the score stays below
  /// `expected_score`.
  ScanMatch track(std::span<const TiledGrid> levels, const PointSet& points,
                  std::span<const common::Pose2> seeds, const SearchWindow& window, double expected_score);

  /// Search in the whole window, refined by Gauss-Newton.
  ScanMatch search(std::span<const TiledGrid> levels, const PointSet& points, const SearchWindow& window);

 private:
  ScanMatch align(std::span<const TiledGrid> levels, const PointSet& points, const common::Pose2& seed) const;

  GridSlamConfig config_;
  CorrelativeSearch correlative_;
};

}  // namespace rubble::slam_lidar
