#include "geometry/sim3.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>

#include "geometry/least_squares.h"
#include "geometry/ransac.h"

namespace rubble::slam_mono {
namespace {

using Vector7 = Eigen::Matrix<double, 7, 1>;

// Squared, normalised, of a point without a pixel or further off than this: lens polynomials run wild far
// outside the picture.
constexpr double kUnseenError = 1e5;
constexpr double kMinTriangle = 0.02;  // twice the area over the longest side's square
constexpr double kHuberBound = 5.991;  // chi2, 2 dof, 95 %
// Relative, of a point's depth in either map. Without it the scale rests on the parallax between a and b
// alone: seen from one place twice, no picture tells it.
constexpr double kDepthSigma = 0.1;
constexpr double kDepthBound = 3.841;  // chi2, 1 dof, 95 %
constexpr int kIterations = 20;
constexpr int kRefinements = 3;

bool isTriangle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const double longest = std::max({(a - b).squaredNorm(), (b - c).squaredNorm(), (a - c).squaredNorm()});
  return (b - a).cross(c - a).norm() > kMinTriangle * longest;
}

/// Horn 1987, sections 2.C (scale, symmetric in both sides) and 4 (rotation).
std::optional<Sim3> similarityOf(const PointPair& i, const PointPair& j, const PointPair& k) {
  if (!isTriangle(i.p_a, j.p_a, k.p_a) || !isTriangle(i.p_b, j.p_b, k.p_b)) {
    return std::nullopt;
  }
  const Eigen::Vector3d centre_a = (i.p_a + j.p_a + k.p_a) / 3.0;
  const Eigen::Vector3d centre_b = (i.p_b + j.p_b + k.p_b) / 3.0;
  Eigen::Matrix3d M = Eigen::Matrix3d::Zero();
  double spread_a = 0.0;
  double spread_b = 0.0;
  for (const PointPair* pair : {&i, &j, &k}) {
    M += (pair->p_b - centre_b) * (pair->p_a - centre_a).transpose();
    spread_a += (pair->p_a - centre_a).squaredNorm();
    spread_b += (pair->p_b - centre_b).squaredNorm();
  }
  const Eigen::Vector3d skew(M(1, 2) - M(2, 1), M(2, 0) - M(0, 2), M(0, 1) - M(1, 0));
  Eigen::Matrix4d N;
  N(0, 0) = M.trace();
  N.block<3, 1>(1, 0) = skew;
  N.block<1, 3>(0, 1) = skew.transpose();
  N.block<3, 3>(1, 1) = M + M.transpose() - M.trace() * Eigen::Matrix3d::Identity();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> solver(N);
  const Eigen::Vector4d q = solver.eigenvectors().col(3);
  Sim3 S(Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized(), Eigen::Vector3d::Zero(),
         std::sqrt(spread_a / spread_b));
  S.translation = centre_a - S * centre_b;
  return S;
}

/// exp(delta) * S to first order in the translation, delta = (v; w; log scale).
Sim3 moved(const Sim3& S, const Vector7& delta) {
  const Eigen::Vector3d w = delta.segment<3>(3);
  const double angle = w.norm();
  Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
  if (angle > 0.0) {
    q = Eigen::AngleAxisd(angle, w / angle);
  }
  return Sim3(q, delta.head<3>(), std::exp(delta[6])) * S;
}

struct PairErrors {
  double a = kUnseenError;  ///< squared, normalised
  double b = kUnseenError;
};

PairErrors errorsOf(const Camera& camera, const PointPair& pair, const Sim3& S_a_b, const Sim3& S_b_a) {
  PairErrors errors;
  if (const auto pixel = camera.project(S_a_b * pair.p_b)) {
    errors.a = (*pixel - pair.pixel_a).squaredNorm() / (pair.sigma_a * pair.sigma_a);
  }
  if (const auto pixel = camera.project(S_b_a * pair.p_a)) {
    errors.b = (*pixel - pair.pixel_b).squaredNorm() / (pair.sigma_b * pair.sigma_b);
  }
  return errors;
}

/// d (p + v + w x p + s p) / d (v; w; s).
Eigen::Matrix<double, 3, 7> motionJacobian(const Eigen::Vector3d& p) {
  Eigen::Matrix<double, 3, 7> J;
  J.leftCols<3>().setIdentity();
  J.middleCols<3>(3) << 0.0, p.z(), -p.y(),  //
      -p.z(), 0.0, p.x(),                    //
      p.y(), -p.x(), 0.0;
  J.col(6) = p;
  return J;
}

void addError(const Camera& camera, const Eigen::Vector3d& p,
              const Eigen::Matrix<double, 3, 7>& point_jacobian, const Eigen::Vector2d& wanted, double sigma,
              NormalEquations<7>& equations) {
  const auto pixel = camera.project(p);
  const Eigen::Vector2d error = pixel ? Eigen::Vector2d((*pixel - wanted) / sigma) : Eigen::Vector2d::Zero();
  const double squared = pixel ? error.squaredNorm() : kUnseenError;
  if (!(squared < kUnseenError)) {
    equations.cost += huberCost(kUnseenError, kHuberBound);
    return;
  }
  equations.cost += huberCost(squared, kHuberBound);
  equations.add<2>(camera.projectJacobian(p) * point_jacobian / sigma, error,
                   huberWeight(squared, kHuberBound));
}

/// The distances that both maps give the point, as logarithms.
void addDepth(const Eigen::Vector3d& p, const Eigen::Matrix<double, 3, 7>& point_jacobian,
              const Eigen::Vector3d& wanted, NormalEquations<7>& equations) {
  using Scalar = Eigen::Matrix<double, 1, 1>;
  const Scalar error(0.5 * std::log(p.squaredNorm() / wanted.squaredNorm()) / kDepthSigma);
  if (!error.allFinite()) {
    return;
  }
  const double squared = error.squaredNorm();
  equations.cost += huberCost(squared, kDepthBound);
  equations.add<1>(p.transpose() * point_jacobian / (p.squaredNorm() * kDepthSigma), error,
                   huberWeight(squared, kDepthBound));
}

NormalEquations<7> linearize(const Camera& camera, std::span<const PointPair> pairs,
                             const std::vector<bool>& active, const Sim3& S_a_b) {
  NormalEquations<7> equations;
  const Sim3 S_b_a = S_a_b.inverse();
  const Eigen::Matrix3d back = -S_b_a.scale * S_b_a.rotation.toRotationMatrix();
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (!active[i]) {
      continue;
    }
    const Eigen::Vector3d p_a = S_a_b * pairs[i].p_b;
    addDepth(p_a, motionJacobian(p_a), pairs[i].p_a, equations);
    addError(camera, p_a, motionJacobian(p_a), pairs[i].pixel_a, pairs[i].sigma_a, equations);
    // (exp(delta) S)^-1 p_a = S^-1 exp(-delta) p_a.
    addError(camera, S_b_a * pairs[i].p_a, back * motionJacobian(pairs[i].p_a), pairs[i].pixel_b,
             pairs[i].sigma_b, equations);
  }
  return equations;
}

void findInliers(const Camera& camera, std::span<const PointPair> pairs, double max_error,
                 Sim3Result& result) {
  const Sim3 S_b_a = result.S_a_b.inverse();
  result.inliers.assign(pairs.size(), false);
  result.inlier_count = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const PairErrors errors = errorsOf(camera, pairs[i], result.S_a_b, S_b_a);
    result.inliers[i] = std::max(errors.a, errors.b) <= max_error * max_error;
    result.inlier_count += result.inliers[i] ? 1 : 0;
  }
}

void refineOver(const Camera& camera, std::span<const PointPair> pairs, const std::vector<bool>& active,
                Sim3& S_a_b) {
  levenbergMarquardt<7>(
      S_a_b, kIterations, [&](const Sim3& S) { return linearize(camera, pairs, active, S); }, moved);
}

/// Truncated cost (MSAC, Torr & Zisserman 2000); gives up above `enough`.
double costOf(const Camera& camera, std::span<const PointPair> pairs, const Sim3& S_a_b, double max_error,
              double enough) {
  const Sim3 S_b_a = S_a_b.inverse();
  double cost = 0.0;
  for (std::size_t i = 0; i < pairs.size() && cost < enough; ++i) {
    const PairErrors errors = errorsOf(camera, pairs[i], S_a_b, S_b_a);
    cost += std::min(std::max(errors.a, errors.b), max_error * max_error);
  }
  return cost;
}

}  // namespace

std::optional<Sim3Result> solveSim3(const Camera& camera, std::span<const PointPair> pairs,
                                    const Sim3Config& config) {
  if (pairs.size() < static_cast<std::size_t>(std::max(3, config.min_inliers))) {
    return std::nullopt;
  }
  std::mt19937_64 random(config.seed);
  Sim3Result best;
  double best_cost = std::numeric_limits<double>::infinity();
  int needed = config.iterations;
  for (int i = 0; i < needed; ++i) {
    const auto [j, k, l] = randomSample<3>(random, pairs.size());
    const auto S_a_b = similarityOf(pairs[j], pairs[k], pairs[l]);
    if (!S_a_b) {
      continue;
    }
    const double cost = costOf(camera, pairs, *S_a_b, config.max_error, best_cost);
    if (cost < best_cost) {
      best_cost = cost;
      best.S_a_b = *S_a_b;
      findInliers(camera, pairs, config.max_error, best);
      needed = ransacIterations(static_cast<double>(best.inlier_count) / static_cast<double>(pairs.size()), 3,
                                config.iterations);
    }
  }
  // Three noisy points put some inliers outside the bound: they may join a refined similarity.
  for (int i = 0; i < kRefinements && best.inlier_count >= 3; ++i) {
    const int before = best.inlier_count;
    refineOver(camera, pairs, best.inliers, best.S_a_b);
    findInliers(camera, pairs, config.max_error, best);
    if (best.inlier_count <= before) {
      break;
    }
  }
  if (best.inlier_count < config.min_inliers) {
    return std::nullopt;
  }
  return best;
}

Sim3Result refineSim3(const Camera& camera, std::span<const PointPair> pairs, const Sim3& S_a_b_start,
                      double max_error) {
  Sim3Result result;
  result.S_a_b = S_a_b_start;
  refineOver(camera, pairs, std::vector<bool>(pairs.size(), true), result.S_a_b);
  findInliers(camera, pairs, max_error, result);
  if (result.inlier_count >= 3) {
    // Without the outliers' pull.
    refineOver(camera, pairs, result.inliers, result.S_a_b);
    findInliers(camera, pairs, max_error, result);
  }
  return result;
}

}  // namespace rubble::slam_mono
