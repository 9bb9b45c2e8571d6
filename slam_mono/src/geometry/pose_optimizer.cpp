#include "geometry/pose_optimizer.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/least_squares.h"

namespace rubble::slam_mono {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr int kRounds = 4;
constexpr int kIterations = 10;
constexpr int kMinInliers = 3;
// Squared, normalised, of a point without a pixel or further off than this: lens polynomials run wild far
// outside the picture.
constexpr double kUnseenError = 1e5;
constexpr double kLeastBlur = 1e-3;  // sigma, of a point's uncertainty in the picture
// A point's uncertainty takes the keyframes' poses as exact. What these are off, the points of a view have in
// common: no number of them averages it out.
constexpr double kInCommon = 5.0;

double squaredError(const Camera& camera, const PointObservation& observation, const common::Pose3& T) {
  const auto pixel = camera.project(T * observation.p_mono_point);
  return pixel ? (*pixel - observation.pixel).squaredNorm() / (observation.sigma * observation.sigma)
               : kUnseenError;
}

/// Square root of the inverse covariance of an observation's error: the feature's own noise, and how the
/// point's uncertainty shows in the picture from T.
Eigen::Matrix2d whitening(const Camera& camera, const PointObservation& observation, const common::Pose3& T) {
  Eigen::Matrix2d W = Eigen::Matrix2d::Identity() / observation.sigma;
  const Eigen::Vector3d p = T * observation.p_mono_point;
  if (!camera.project(p)) {
    return W;  // It is not looked at from there.
  }
  const Eigen::Vector2d blur = kInCommon * camera.projectJacobian(p) * (T.linear() * observation.uncertainty);
  const double length = blur.norm();
  if (length > kLeastBlur * observation.sigma) {
    const Eigen::Vector2d line = blur / length;
    W += (1.0 / std::hypot(observation.sigma, length) - 1.0 / observation.sigma) * line * line.transpose();
  }
  return W;
}

NormalEquations<6> linearize(const Camera& camera, const common::Pose3& T,
                             std::span<const PointObservation> observations,
                             std::span<const Eigen::Matrix2d> whitenings, const std::vector<bool>& active,
                             bool robust) {
  NormalEquations<6> equations;
  const double bound = robust ? kChi2Two : std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < observations.size(); ++i) {
    if (!active[i]) {
      continue;
    }
    const Eigen::Vector3d p = T * observations[i].p_mono_point;
    const auto pixel = camera.project(p);
    const Eigen::Vector2d error =
        pixel ? Eigen::Vector2d(whitenings[i] * (*pixel - observations[i].pixel)) : Eigen::Vector2d::Zero();
    const double squared = pixel ? error.squaredNorm() : kUnseenError;
    if (!(squared < kUnseenError)) {
      equations.cost += huberCost(kUnseenError, bound);
      continue;
    }
    equations.cost += huberCost(squared, bound);
    equations.add<2>(whitenings[i] * poseJacobian(camera, p), error, huberWeight(squared, bound));
  }
  return equations;
}

/// Covariance of the camera's pose in mono, infinite where the inliers do not fix it.
Matrix6 covarianceOf(const Camera& camera, const common::Pose3& T_camera_mono,
                     std::span<const PointObservation> observations,
                     std::span<const Eigen::Matrix2d> whitenings, const PoseOptimum& optimum) {
  Matrix6 covariance = Matrix6::Zero();
  covariance.diagonal().setConstant(std::numeric_limits<double>::infinity());
  if (optimum.inlier_count < kMinInliers) {
    return covariance;
  }
  const NormalEquations<6> equations =
      linearize(camera, T_camera_mono, observations, whitenings, optimum.inliers, false);
  // Scaled to a unit diagonal: metres and radians differ.
  const Vector6 diagonal = equations.H.diagonal();
  if (!(diagonal.minCoeff() > 0.0)) {
    return covariance;
  }
  const Vector6 scale = diagonal.cwiseSqrt().cwiseInverse();
  const Eigen::LDLT<Matrix6> ldlt(scale.asDiagonal() * equations.H * scale.asDiagonal());
  if (ldlt.info() != Eigen::Success || !(ldlt.vectorD().minCoeff() > 1e-12)) {
    return covariance;
  }
  const double freedom = std::max(1.0, 2.0 * optimum.inlier_count - 6.0);
  const double variance = std::max(1.0, equations.cost / freedom);
  const Matrix6 local = variance * scale.asDiagonal() * ldlt.solve(Matrix6::Identity()) * scale.asDiagonal();
  // A motion (v; w) of T_camera_mono moves the camera in mono by -R_mono_camera (v; w), to first order.
  Matrix6 A = Matrix6::Zero();
  A.topLeftCorner<3, 3>() = T_camera_mono.linear().transpose();
  A.bottomRightCorner<3, 3>() = T_camera_mono.linear().transpose();
  covariance = A * local * A.transpose();
  return 0.5 * (covariance + covariance.transpose());
}

}  // namespace

Eigen::Matrix<double, 2, 6> poseJacobian(const Camera& camera, const Eigen::Vector3d& p_camera) {
  const Eigen::Matrix<double, 2, 3> P = camera.projectJacobian(p_camera);
  Eigen::Matrix<double, 2, 6> J;
  J.leftCols<3>() = P;
  // -P [p]x, row by row: (p x row).
  J.col(3) = p_camera.y() * P.col(2) - p_camera.z() * P.col(1);
  J.col(4) = p_camera.z() * P.col(0) - p_camera.x() * P.col(2);
  J.col(5) = p_camera.x() * P.col(1) - p_camera.y() * P.col(0);
  return J;
}

common::Pose3 perturbed(const common::Pose3& T, const Eigen::Matrix<double, 6, 1>& delta) {
  const Eigen::Vector3d w = delta.tail<3>();
  const double angle = w.norm();
  Eigen::Quaterniond q(1.0, 0.5 * w.x(), 0.5 * w.y(), 0.5 * w.z());
  if (angle > 1e-8) {
    q = Eigen::AngleAxisd(angle, w / angle);
  }
  common::Pose3 result = common::Pose3::Identity();
  // Through a unit quaternion: no drift away from a rotation.
  result.linear() = (q.normalized() * Eigen::Quaterniond(T.linear())).normalized().toRotationMatrix();
  result.translation() = q.normalized() * T.translation() + delta.head<3>();
  return result;
}

PoseOptimum optimizePose(const Camera& camera, const common::Pose3& T_camera_mono_start,
                         std::span<const PointObservation> observations) {
  PoseOptimum optimum;
  optimum.T_camera_mono = T_camera_mono_start;
  optimum.inliers.assign(observations.size(), true);
  optimum.inlier_count = static_cast<int>(observations.size());
  std::vector<bool> before;
  std::vector<Eigen::Matrix2d> whitenings(observations.size());
  for (int round = 0; round < kRounds && optimum.inlier_count >= kMinInliers; ++round) {
    // As ORB-SLAM: once the outliers are out, the kernel would only bias the rest.
    const bool robust = round + 1 < kRounds;
    if (robust && optimum.inliers == before) {
      continue;  // the same minimum again
    }
    before = optimum.inliers;
    // Once a round: with weights that change on the way no step could be judged by the cost.
    std::transform(observations.begin(), observations.end(), whitenings.begin(),
                   [&](const PointObservation& o) { return whitening(camera, o, optimum.T_camera_mono); });
    levenbergMarquardt<6>(
        optimum.T_camera_mono, kIterations,
        [&](const common::Pose3& T) {
          return linearize(camera, T, observations, whitenings, optimum.inliers, robust);
        },
        perturbed);
    optimum.inlier_count = 0;
    for (std::size_t i = 0; i < observations.size(); ++i) {
      optimum.inliers[i] = squaredError(camera, observations[i], optimum.T_camera_mono) <= kChi2Two;
      optimum.inlier_count += optimum.inliers[i] ? 1 : 0;
    }
  }
  if (optimum.inlier_count < kMinInliers) {
    // Fewer than three observations are not even tried, and support nothing.
    optimum.inliers.assign(observations.size(), false);
    optimum.inlier_count = 0;
  }
  optimum.covariance = covarianceOf(camera, optimum.T_camera_mono, observations, whitenings, optimum);
  return optimum;
}

}  // namespace rubble::slam_mono
