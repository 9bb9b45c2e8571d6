#include "gauss_newton.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace rubble::slam_lidar {
namespace {

/// Pull towards the seed per unit of weight (1/m^2, 1/m^2, 1/rad^2). It is below what one beam in a hundred
/// brings across a wall at the finest level and fades with the distance, so it decides only where the scan
/// says nothing: along a bare corridor, where noise would have the pose slide away.
constexpr double kAnchorTranslation = 0.5;
constexpr double kAnchorYaw = 0.1;
constexpr double kAnchorFadeDistance = 0.3;  // metres
constexpr double kAnchorFadeAngle = 0.1;     // radians

constexpr double kMaxStepCells = 2.0;
constexpr double kMaxStepYaw = 0.2;  // radians
constexpr double kConvergedCells = 0.01;
constexpr double kConvergedYaw = 1e-4;  // radians

double faded(double weight, double off, double scale) {
  const double ratio = off / scale;
  return weight / (1.0 + ratio * ratio);
}

Eigen::Vector3d gaussNewtonStep(const MatchSums& sums, const common::Pose2& T, const common::Pose2& T_seed,
                                double total_weight) {
  const Eigen::Vector3d off(T.x - T_seed.x, T.y - T_seed.y, common::wrapAngle(T.yaw - T_seed.yaw));
  const double translation =
      total_weight * faded(kAnchorTranslation, off.head<2>().norm(), kAnchorFadeDistance);
  const Eigen::Vector3d anchor(translation, translation,
                               total_weight * faded(kAnchorYaw, off.z(), kAnchorFadeAngle));
  Eigen::Matrix3d H = sums.H;
  H.diagonal() += anchor;
  return H.ldlt().solve(sums.g - anchor.cwiseProduct(off));
}

}  // namespace

Match alignScan(std::span<const TiledGrid> levels, const PointSet& points, const common::Pose2& T_world_seed,
                int max_iterations) {
  Match match;
  common::Pose2& T = match.T_world_lidar;
  T = T_world_seed;
  for (std::size_t level = levels.size(); level-- > 0;) {
    const GridView view = levels[level].view();
    for (int i = 0; i < max_iterations; ++i, ++match.iterations) {
      Eigen::Vector3d step =
          gaussNewtonStep(linearise(view, points, T), T, T_world_seed, points.totalWeight());
      const double largest = std::max(step.head<2>().cwiseAbs().maxCoeff() / (kMaxStepCells * view.cell_size),
                                      std::abs(step.z()) / kMaxStepYaw);
      step /= std::max(1.0, largest);
      T = {T.x + step.x(), T.y + step.y(), common::wrapAngle(T.yaw + step.z())};
      if (step.head<2>().norm() < kConvergedCells * view.cell_size && std::abs(step.z()) < kConvergedYaw) {
        break;
      }
    }
  }
  match.sums = linearise(levels.front().view(), points, T);
  return match;
}

}  // namespace rubble::slam_lidar
