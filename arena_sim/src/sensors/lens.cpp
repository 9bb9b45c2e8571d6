#include "sensors/lens.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "common/error.h"

namespace rubble::arena_sim {

namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kSmallestSlope = 1e-3;
constexpr double kExact = 1e-6;  // pixels

Vector2d pairOf(const std::vector<double>& values) { return {values.at(0), values.at(1)}; }

}  // namespace

Lens::Lens(const common::RobotConfig::Intrinsics& intrinsics)
    : is_fisheye_(intrinsics.model == "fisheye"),
      focal_(pairOf(intrinsics.focal)),
      centre_(pairOf(intrinsics.centre)) {
  const std::vector<double>& k = intrinsics.distortion;
  RUBBLE_CHECK(k.size() == 4);
  if (is_fisheye_) {
    std::copy(k.begin(), k.end(), radial_.begin());
  } else {
    radial_ = {k[0], k[1], 0.0, 0.0};
    tangential_ = {k[2], k[3]};
  }
  limit_ = findLimit();
  requireInvertible(intrinsics);
}

Vector2d Lens::project(const Vector3d& p_camera) const {
  Vector2d distorted;
  if (is_fisheye_) {
    const double radius = p_camera.head<2>().norm();
    const double angle = std::atan2(radius, p_camera.z());
    distorted =
        radius > 0.0 ? Vector2d(distortRadius(angle) / radius * p_camera.head<2>()) : Vector2d(0.0, 0.0);
  } else {
    distorted = distortPinhole(p_camera.head<2>() / p_camera.z(), nullptr);
  }
  return distorted.cwiseProduct(focal_) + centre_;
}

Vector3d Lens::unproject(const Vector2d& pixel) const {
  const auto ray = tryUnproject(pixel);
  RUBBLE_CHECK(ray.has_value());
  return *ray;
}

std::optional<Vector3d> Lens::tryUnproject(const Vector2d& pixel) const {
  const Vector2d distorted = (pixel - centre_).cwiseQuotient(focal_);
  if (!is_fisheye_) {
    const auto p = undistortPinhole(distorted);
    return p ? std::optional(Vector3d(p->x(), p->y(), 1.0).normalized()) : std::nullopt;
  }
  const double radius = distorted.norm();
  if (radius > distortRadius(limit_)) {
    return std::nullopt;
  }
  const double angle = undistortRadius(radius);
  const Vector2d side = radius > 0.0 ? Vector2d(std::sin(angle) / radius * distorted) : Vector2d(0.0, 0.0);
  return Vector3d(side.x(), side.y(), std::cos(angle));
}

/// Newton from the answer without tangential distortion.
std::optional<Vector2d> Lens::undistortPinhole(const Vector2d& distorted) const {
  const double radius = distorted.norm();
  Vector2d p = radius > 0.0 ? Vector2d(undistortRadius(radius) / radius * distorted) : distorted;
  constexpr int kMaxSteps = 30;
  for (int i = 0; i < kMaxSteps; ++i) {
    Matrix2d jacobian;
    const Vector2d residual = distortPinhole(p, &jacobian) - distorted;
    if (p.norm() > limit_ || jacobian.determinant() < kSmallestSlope) {
      return std::nullopt;
    }
    if (residual.cwiseProduct(focal_).norm() < 1e-2 * kExact) {
      return p;
    }
    p -= jacobian.inverse() * residual;
  }
  return std::nullopt;
}

Vector2d Lens::distortPinhole(const Vector2d& p, Matrix2d* jacobian) const {
  const double x = p.x();
  const double y = p.y();
  const double r2 = p.squaredNorm();
  const auto [p1, p2] = std::pair(tangential_.x(), tangential_.y());
  const double scale = 1.0 + r2 * (radial_[0] + r2 * radial_[1]);
  if (jacobian != nullptr) {
    const double slope = 2.0 * (radial_[0] + 2.0 * r2 * radial_[1]);
    *jacobian << scale + slope * x * x + 2.0 * p1 * y + 6.0 * p2 * x,
        slope * x * y + 2.0 * p1 * x + 2.0 * p2 * y,  //
        slope * x * y + 2.0 * p1 * x + 2.0 * p2 * y, scale + slope * y * y + 6.0 * p1 * y + 2.0 * p2 * x;
  }
  return {scale * x + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
          scale * y + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y};
}

double Lens::distortRadius(double radius) const {
  const double r2 = radius * radius;
  return radius * (1.0 + r2 * (radial_[0] + r2 * (radial_[1] + r2 * (radial_[2] + r2 * radial_[3]))));
}

double Lens::radiusSlope(double radius) const {
  const double r2 = radius * radius;
  return 1.0 +
         r2 * (3.0 * radial_[0] + r2 * (5.0 * radial_[1] + r2 * (7.0 * radial_[2] + r2 * 9.0 * radial_[3])));
}

/// Newton inside a shrinking bracket; never beyond limit_.
double Lens::undistortRadius(double distorted) const {
  double low = 0.0;
  double high = limit_;
  double radius = std::min(distorted, limit_);
  constexpr int kMaxSteps = 100;
  for (int i = 0; i < kMaxSteps && high - low > 0.0; ++i) {
    const double error = distortRadius(radius) - distorted;
    (error > 0.0 ? high : low) = radius;
    const double newton = radius - error / radiusSlope(radius);
    const double next = newton > low && newton < high ? newton : 0.5 * (low + high);
    if (std::abs(next - radius) < 1e-15) {
      break;
    }
    radius = next;
  }
  return radius;
}

double Lens::findLimit() const {
  const double farthest = is_fisheye_ ? 3.0 : 10.0;
  constexpr double kStep = 1e-3;
  double radius = 0.0;
  while (radius < farthest && radiusSlope(radius + kStep) > kSmallestSlope) {
    radius += kStep;
  }
  return radius;
}

void Lens::requireInvertible(const common::RobotConfig::Intrinsics& intrinsics) const {
  constexpr int kSteps = 24;
  const Vector2d first(-0.5 - kMargin, -0.5 - kMargin);
  const Vector2d size(intrinsics.width + 2.0 * kMargin, intrinsics.height + 2.0 * kMargin);
  for (int i = 0; i <= kSteps * kSteps; ++i) {
    const Vector2d share = Vector2d(i % kSteps, i / kSteps) / (kSteps - 1);
    const Vector2d pixel = first + size.cwiseProduct(share.cwiseMin(1.0));
    const auto ray = tryUnproject(pixel);
    if (!ray || (project(*ray) - pixel).norm() > kExact) {
      throw common::Error(fmt::format(
          "robot.camera: the {} lens with distortion [{}] has no single ray for pixel ({:.0f}, {:.0f}), it "
          "folds the picture over; correct distortion, focal, centre or model",
          intrinsics.model, fmt::join(intrinsics.distortion, ", "), pixel.x(), pixel.y()));
    }
  }
}

}  // namespace rubble::arena_sim
