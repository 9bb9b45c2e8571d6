#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/geometry.h"
#include "tiled_grid.h"

namespace rubble::slam_lidar {

/// Beam end points in the level LiDAR frame, metres, as the kernel wants them: structure of arrays, padded
/// with points of weight 0 to a multiple of kPadding.
class PointSet {
 public:
  static constexpr std::size_t kPadding = 16;

  void clear();
  void add(float x, float y, float weight);
  /// Fills up the last vector; add() is not allowed afterwards.
  void pad();

  std::size_t size() const { return size_; }
  std::size_t paddedSize() const { return x_.size(); }
  const float* x() const { return x_.data(); }
  const float* y() const { return y_.data(); }
  const float* weight() const { return weight_.data(); }
  double totalWeight() const { return total_weight_; }

 private:
  std::size_t size_ = 0;
  double total_weight_ = 0.0;
  std::vector<float> x_;
  std::vector<float> y_;
  std::vector<float> weight_;
};

/// Sums over all points of a scan at one pose. M is the bilinearly interpolated occupancy in [0, 1] at the
/// point, J = dM/d(x, y, yaw) in 1/m, 1/m, 1/rad (Kohlbrecher et al. 2011, eq. 5, 6, 12).
struct MatchSums {
  Eigen::Matrix3d H = Eigen::Matrix3d::Zero();  ///< sum w J^T J
  Eigen::Vector3d g = Eigen::Vector3d::Zero();  ///< sum w J^T (1 - M)
  double agree = 0.0;                           ///< sum w max(0, M - M_unknown), 1: surely occupied
  double contradict = 0.0;                      ///< sum w max(0, M_unknown - M), 1: surely free

  double cost = 0.0;  ///< sum w (1 - M)^2, linearise() only

  /// What searches maximise.
  double quality() const { return agree - 0.5 * contradict; }
};

/// All of MatchSums, for Gauss-Newton.
MatchSums linearise(const GridView& grid, const PointSet& points, const common::Pose2& T_world_lidar);

/// Only agree and contradict, for searches.
MatchSums evaluate(const GridView& grid, const PointSet& points, const common::Pose2& T_world_lidar);

/// linearise() written plainly, cell by cell: the oracle the SIMD code is tested against.
MatchSums lineariseScalar(const GridView& grid, const PointSet& points, const common::Pose2& T_world_lidar);

}  // namespace rubble::slam_lidar
