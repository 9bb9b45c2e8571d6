#include "geometry/ray_pair.h"

#include <Eigen/LU>
#include <limits>

namespace rubble::slam_mono {

std::optional<RayPair> rayPair(const Camera& camera, const TwoViewMatch& match) {
  const auto byPixel = [&](const Eigen::Vector3d& bearing) -> Eigen::Matrix<double, 3, 2> {
    const Eigen::Matrix<double, 2, 3> J = camera.projectJacobian(bearing);
    return J.transpose() * (J * J.transpose()).inverse();
  };
  RayPair pair;
  pair.pixel_a = match.pixel_a;
  pair.pixel_b = match.pixel_b;
  pair.a = camera.unproject(match.pixel_a);
  pair.b = camera.unproject(match.pixel_b);
  pair.da = byPixel(pair.a);
  pair.db = byPixel(pair.b);
  pair.inverse_variance = 1.0 / (match.sigma * match.sigma);
  const auto back_a = camera.project(pair.a);
  const auto back_b = camera.project(pair.b);
  const bool valid = back_a && back_b && (*back_a - match.pixel_a).norm() < 1e-3 &&
                     (*back_b - match.pixel_b).norm() < 1e-3 && pair.da.allFinite() && pair.db.allFinite();
  return valid ? std::optional(pair) : std::nullopt;
}

Eigen::Matrix3d essentialOf(const common::Pose3& T_b_a) {
  const Eigen::Vector3d t = T_b_a.translation();
  Eigen::Matrix3d cross;
  cross << 0.0, -t.z(), t.y(), t.z(), 0.0, -t.x(), -t.y(), t.x(), 0.0;
  return cross * T_b_a.linear();
}

double transferChi2(const Camera& camera, const Eigen::Matrix3d& H, const Eigen::Matrix3d& Hi,
                    const RayPair& pair) {
  const auto in_b = camera.project(H * pair.a);
  const auto in_a = camera.project(Hi * pair.b);
  if (!in_a || !in_b) {
    return std::numeric_limits<double>::infinity();
  }
  return 0.25 * pair.inverse_variance *
         ((*in_a - pair.pixel_a).squaredNorm() + (*in_b - pair.pixel_b).squaredNorm());
}

}  // namespace rubble::slam_mono
