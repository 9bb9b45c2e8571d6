#include "marks/triangulation.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace rubble::fusion {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Of the camera's place, which is alike in all views (m).
constexpr double kPlaceSigma = 0.03;
/// What is known before anything tells the distance (m).
constexpr double kUsualRange = 2.0;
constexpr double kUsualRangeSigma = 2.0;
constexpr double kNearest = 0.1;
constexpr double kHuber = 2.0;
constexpr int kIterations = 15;

double huberWeight(double normalised) { return normalised <= kHuber ? 1.0 : kHuber / normalised; }

/// Sums up the normal equations at p.
struct NormalEquations {
  Matrix3d H = Matrix3d::Zero();
  Vector3d b = Vector3d::Zero();

  void addBearing(const MarkView& view, const Vector3d& p) {
    const Vector3d v = p - view.p_world_camera;
    const double range = std::max(v.norm(), kNearest);
    // What is across the bearing, as an angle.
    const Matrix3d across = Matrix3d::Identity() - view.d_world * view.d_world.transpose();
    const Vector3d r = across * v / (range * view.bearing_sigma);
    const double behind = v.dot(view.d_world) < 0.0 ? 0.1 : 1.0;
    const double weight = behind * huberWeight(r.norm()) / std::pow(range * view.bearing_sigma, 2);
    H += weight * across;
    b += weight * across * v;
  }

  void addRange(const MarkView& view, double measured, double sigma, const Vector3d& p) {
    const Vector3d v = p - view.p_world_camera;
    const double range = std::max(v.norm(), kNearest);
    const Vector3d direction = v / range;
    const double r = range - measured;
    const double weight = huberWeight(std::abs(r) / sigma) / (sigma * sigma);
    H += weight * direction * direction.transpose();
    b += weight * r * direction;
  }

  /// What is usual, along the bearing: unlike addRange, it does not also hold behind the camera.
  void addUsualDepth(const MarkView& view, const Vector3d& p) {
    const Vector3d& d = view.d_world;
    const double weight = 1.0 / (kUsualRangeSigma * kUsualRangeSigma);
    H += weight * d * d.transpose();
    b += weight * (d.dot(p - view.p_world_camera) - kUsualRange) * d;
  }
};

NormalEquations equationsAt(std::span<const MarkView> views, const Vector3d& p) {
  NormalEquations equations;
  // Ranges err alike: what stands before the object does so in every view.
  const double alike = std::sqrt(static_cast<double>(
      std::count_if(views.begin(), views.end(), [](const MarkView& v) { return v.range_sigma > 0.0; })));
  for (const MarkView& view : views) {
    equations.addBearing(view, p);
    if (view.range_sigma > 0.0) {
      equations.addRange(view, view.range, alike * view.range_sigma, p);
    }
  }
  if (views.front().bearing_sigma > kCornerSigma) {  // Unsure bearings may cross there.
    equations.addUsualDepth(views.front(), p);
  } else {
    equations.addRange(views.front(), kUsualRange, kUsualRangeSigma, p);
  }
  return equations;
}

}  // namespace

double largestSigma(const Matrix3d& covariance) {
  return std::sqrt(Eigen::SelfAdjointEigenSolver<Matrix3d>(covariance).eigenvalues().maxCoeff());
}

MarkPosition triangulate(std::span<const MarkView> views) {
  const auto* best = &views.front();
  for (const MarkView& view : views) {
    if (view.range_sigma > 0.0 && (best->range_sigma <= 0.0 || view.range_sigma < best->range_sigma)) {
      best = &view;
    }
  }
  MarkPosition result;
  result.p_world =
      best->p_world_camera + (best->range_sigma > 0.0 ? best->range : kUsualRange) * best->d_world;
  for (int i = 0; i < kIterations; ++i) {
    const NormalEquations equations = equationsAt(views, result.p_world);
    const Vector3d step = equations.H.ldlt().solve(equations.b);
    result.p_world -= step;
    if (step.norm() < 1e-5) {
      break;
    }
  }
  result.covariance = equationsAt(views, result.p_world).H.inverse();
  result.covariance += kPlaceSigma * kPlaceSigma * Matrix3d::Identity();
  return result;
}

}  // namespace rubble::fusion
