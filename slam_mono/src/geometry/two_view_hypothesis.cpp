#include "geometry/two_view_hypothesis.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "geometry/least_squares.h"

namespace rubble::slam_mono {
namespace {

using Vector5 = Eigen::Matrix<double, 5, 1>;

// Wider at first, for a start beside the minimum. Not much: outliers that lie along the epipolar lines are
// many.
constexpr double kBounds[] = {4.0 * kChi2One, 4.0 * kChi2One, 4.0 * kChi2One, kChi2One};
constexpr int kIterations = 15;

/// The translation has two degrees of freedom, along these.
Eigen::Matrix<double, 3, 2> tangents(const Eigen::Vector3d& t) {
  Eigen::Matrix<double, 3, 2> basis;
  basis.col(0) = t.unitOrthogonal();
  basis.col(1) = t.cross(basis.col(0));
  return basis;
}

/// delta = (rotation vector; translation along the tangents).
common::Pose3 moved(const common::Pose3& T, const Vector5& delta) {
  const Eigen::Vector3d w = delta.head<3>();
  Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
  if (w.norm() > 0.0) {
    q = Eigen::AngleAxisd(w.norm(), w.normalized());
  }
  common::Pose3 result = common::Pose3::Identity();
  result.linear() = (q * Eigen::Quaterniond(T.linear())).normalized().toRotationMatrix();
  result.translation() = (T.translation() + tangents(T.translation()) * delta.tail<2>()).normalized();
  return result;
}

NormalEquations<5> linearize(const common::Pose3& T_b_a, std::span<const RayPair* const> pairs) {
  NormalEquations<5> equations;
  const Eigen::Vector3d t = T_b_a.translation();
  const Eigen::Matrix3d E = essentialOf(T_b_a);
  const Eigen::Matrix<double, 3, 2> basis = tangents(t);
  for (const RayPair* pair : pairs) {
    const EpipolarError error(E, *pair);
    const double scale = std::sqrt(pair->inverse_variance / error.squaredSlope());
    const double squared = error.value * error.value * scale * scale;
    // Of the value b (t x a) = t (a x b) = a (b x t), a turned into b, and of half the squared slope
    // |da^T R^T (b x t)|^2 + |db^T (t x a)|^2.
    const Eigen::Vector3d& b = pair->b;
    const Eigen::Vector3d a = T_b_a.linear() * pair->a;
    const Eigen::Vector3d n = b.cross(t);
    const Eigen::Vector3d slope_a = T_b_a.linear() * (pair->da * error.by_pixel_a);
    const Eigen::Vector3d slope_b = pair->db * error.by_pixel_b;
    const double ratio = error.value / error.squaredSlope();
    const Eigen::Vector3d by_turn = a.cross(n) - ratio * (slope_a.cross(n) + a.cross(slope_b.cross(t)));
    const Eigen::Vector3d by_t = a.cross(b) - ratio * (slope_a.cross(b) + a.cross(slope_b));
    Eigen::Matrix<double, 1, 5> J;
    J << by_turn.transpose(), by_t.transpose() * basis;
    equations.cost += huberCost(squared, kChi2One);
    equations.add<1>(J * scale, Eigen::Matrix<double, 1, 1>(error.value * scale),
                     huberWeight(squared, kChi2One));
  }
  return equations;
}

std::vector<const RayPair*> inliersOf(std::span<const RayPair> pairs, const common::Pose3& T_b_a,
                                      double bound) {
  const Eigen::Matrix3d E = essentialOf(T_b_a);
  std::vector<const RayPair*> inliers;
  for (const RayPair& pair : pairs) {
    if (EpipolarError(E, pair).chi2(pair) < bound) {
      inliers.push_back(&pair);
    }
  }
  return inliers;
}

double directionSigma(const common::Pose3& T_b_a, std::span<const RayPair* const> inliers) {
  const NormalEquations<5> equations = linearize(T_b_a, inliers);
  const double freedom = std::max(1.0, static_cast<double>(inliers.size()) - 5.0);
  const Eigen::Matrix<double, 5, 5> covariance =
      equations.H.ldlt().solve(Eigen::Matrix<double, 5, 5>::Identity()) *
      std::max(1.0, equations.cost / freedom);
  return std::sqrt(covariance.diagonal().tail<2>().maxCoeff());
}

/// The point of the pixels moved to where their bearings meet (Hartley & Zisserman 2004, section 12.4), if
/// that explains both.
std::optional<Eigen::Vector3d> goodPoint(const Camera& camera, const common::Pose3& T_b_a,
                                         const RayPair& pair) {
  const EpipolarError error(essentialOf(T_b_a), pair);
  const double step = error.value / error.squaredSlope();
  const Eigen::Vector3d a = (pair.a - step * (pair.da * error.by_pixel_a)).normalized();
  const Eigen::Vector3d b = (pair.b - step * (pair.db * error.by_pixel_b)).normalized();
  const auto p_a = triangulate(T_b_a, a, b);
  if (!p_a) {
    return std::nullopt;
  }
  const auto pixel_a = camera.project(*p_a);
  const auto pixel_b = camera.project(T_b_a * *p_a);
  const double bound = kChi2Two / pair.inverse_variance;
  const bool good = pixel_a && pixel_b && (*pixel_a - pair.pixel_a).squaredNorm() <= bound &&
                    (*pixel_b - pair.pixel_b).squaredNorm() <= bound;
  return good ? p_a : std::nullopt;
}

}  // namespace

void refineEpipolar(std::span<const RayPair> pairs, common::Pose3& T_b_a) {
  std::vector<const RayPair*> before;
  for (const double bound : kBounds) {
    std::vector<const RayPair*> inliers = inliersOf(pairs, T_b_a, bound);
    if (inliers.size() < 5 || inliers == before) {
      continue;
    }
    levenbergMarquardt<5>(
        T_b_a, kIterations, [&](const common::Pose3& T) { return linearize(T, inliers); }, moved);
    before = std::move(inliers);
  }
}

TwoViewHypothesis refineMotion(const Camera& camera, std::span<const RayPair> pairs,
                               std::span<const RayPair> support, const common::Pose3& T_b_a_start) {
  TwoViewHypothesis result;
  result.T_b_a = T_b_a_start;
  refineEpipolar(support, result.T_b_a);
  result.direction_sigma = directionSigma(result.T_b_a, inliersOf(support, result.T_b_a, kChi2One));
  result.inliers = static_cast<int>(inliersOf(pairs, result.T_b_a, kChi2One).size());
  result.points_a.reserve(pairs.size());
  const Eigen::Matrix3d E = essentialOf(result.T_b_a);
  for (const RayPair& pair : pairs) {
    result.points_a.push_back(goodPoint(camera, result.T_b_a, pair));
    const bool good = result.points_a.back().has_value();
    result.point_count += good ? 1 : 0;
    result.strict_count += good && EpipolarError(E, pair).chi2(pair) < kChi2One ? 1 : 0;
  }
  return result;
}

}  // namespace rubble::slam_mono
