#include "gauss_newton.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include "tuning.h"

namespace rubble::slam_lidar {

Match alignScan(std::span<const TiledGrid> levels, const PointSet& points, const common::Pose2& T_world_seed,
                int max_iterations) {
  Match match;
  match.T_world_lidar = T_world_seed;
  for (std::size_t level = levels.size(); level-- > 0;) {
    const GridView view = levels[level].view();
    const double converged_m = 0.01 * view.cell_size;
    const double converged_rad = 1e-4;
    for (int i = 0; i < max_iterations; ++i) {
      match.sums = linearise(view, points, match.T_world_lidar);
      ++match.iterations;
      const double scale = points.totalWeight() * std::pow(TUNE(AL, 1.0), level);
      const Eigen::Vector3d off(match.T_world_lidar.x - T_world_seed.x, match.T_world_lidar.y - T_world_seed.y,
                                common::wrapAngle(match.T_world_lidar.yaw - T_world_seed.yaw));
      const double st = TUNE(ST, 0.3), sy = TUNE(SY, 0.1);
      const double kt = 1.0 / (1.0 + off.head<2>().squaredNorm() / (st * st)), ky = 1.0 / (1.0 + off.z() * off.z() / (sy * sy));
      const Eigen::Vector3d anchor(scale * TUNE(AT, 0.5) * kt, scale * TUNE(AT, 0.5)*kt, scale * TUNE(AY, 0.1)*ky);
      Eigen::Matrix3d H = match.sums.H;
      H.diagonal() += anchor + Eigen::Vector3d(1e-6, 1e-6, 1e-6);
      Eigen::Vector3d step = H.ldlt().solve(match.sums.g - anchor.cwiseProduct(off));
      const double limit = std::max({1.0, std::abs(step.x()) / (2 * view.cell_size), std::abs(step.y()) / (2 * view.cell_size), std::abs(step.z()) / 0.2});
      step /= limit;
      match.T_world_lidar.x += step.x();
      match.T_world_lidar.y += step.y();
      match.T_world_lidar.yaw = common::wrapAngle(match.T_world_lidar.yaw + step.z());
      if (step.head<2>().norm() < converged_m && std::abs(step.z()) < converged_rad) {
        break;
      }
    }
  }
  match.sums = linearise(levels.front().view(), points, match.T_world_lidar);
  return match;
}

}  // namespace rubble::slam_lidar
