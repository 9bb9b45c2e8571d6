#include "slam_mono/camera.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/error.h"

namespace rubble::slam_mono {
namespace {

constexpr double kMaxPinholeRadius = 1e3;  // nothing is seen at right angles to the axis
constexpr double kTinyRadius = 1e-9;       // of a unit bearing: on the axis of a fisheye

/// r * (1 + c0 r^2 + c1 r^4 + c2 r^6 + c3 r^8), the radial part of both models.
struct RadialModel {
  double c[4];

  double value(double r) const {
    const double u = r * r;
    return r * (1.0 + u * (c[0] + u * (c[1] + u * (c[2] + u * c[3]))));
  }
  double slope(double r) const {
    const double u = r * r;
    return 1.0 + u * (3.0 * c[0] + u * (5.0 * c[1] + u * (7.0 * c[2] + u * 9.0 * c[3])));
  }
  /// The radius up to which the value grows, at most `limit`.
  double growthLimit(double limit) const {
    double low = 0.0;
    while (low < limit) {
      double high = std::min(limit, low + 1e-3 * (1.0 + low));
      if (slope(high) <= 0.0) {
        for (int i = 0; i < 60; ++i) {
          const double middle = 0.5 * (low + high);
          (slope(middle) > 0.0 ? low : high) = middle;
        }
        return low;
      }
      low = high;
    }
    return limit;
  }
  /// The radius below `limit` with this value: Newton's method, kept inside a shrinking bracket.
  double invert(double wanted, double limit) const {
    double low = 0.0;
    double high = std::min(limit, std::max(wanted, 1e-3));
    while (value(high) < wanted) {
      if (high >= limit) {
        return limit;
      }
      low = high;
      high = std::min(limit, 2.0 * high);
    }
    double r = std::min(high, wanted);
    for (int i = 0; i < 100; ++i) {
      const double error = value(r) - wanted;
      if (std::abs(error) <= 1e-14 * (1.0 + wanted)) {
        break;
      }
      (error > 0.0 ? high : low) = r;
      const double next = r - error / slope(r);
      r = next > low && next < high ? next : 0.5 * (low + high);
    }
    return r;
  }
};

/// k: k1 k2 p1 p2 k3.
Eigen::Vector2d distorted(const double* k, const Eigen::Vector2d& p) {
  const double xx = p.x() * p.x();
  const double yy = p.y() * p.y();
  const double xy = p.x() * p.y();
  const double u = xx + yy;
  const double radial = 1.0 + u * (k[0] + u * (k[1] + u * k[4]));
  return {p.x() * radial + 2.0 * k[2] * xy + k[3] * (u + 2.0 * xx),
          p.y() * radial + k[2] * (u + 2.0 * yy) + 2.0 * k[3] * xy};
}

Eigen::Matrix2d distortionJacobian(const double* k, const Eigen::Vector2d& p) {
  const double u = p.squaredNorm();
  const double radial = 1.0 + u * (k[0] + u * (k[1] + u * k[4]));
  const double slope = 2.0 * (k[0] + u * (2.0 * k[1] + u * 3.0 * k[4]));
  const double cross = p.x() * p.y() * slope + 2.0 * (k[2] * p.x() + k[3] * p.y());
  Eigen::Matrix2d J;
  J << radial + p.x() * p.x() * slope + 2.0 * k[2] * p.y() + 6.0 * k[3] * p.x(), cross,  //
      cross, radial + p.y() * p.y() * slope + 6.0 * k[2] * p.y() + 2.0 * k[3] * p.x();
  return J;
}

/// The radial part is inverted exactly; the small tangential part is left to Newton steps that must descend.
Eigen::Vector2d undistorted(const double* k, const Eigen::Vector2d& wanted, double max_radius) {
  const RadialModel model{{k[0], k[1], k[4], 0.0}};
  const double radius = wanted.norm();
  if (radius == 0.0 && k[2] == 0.0 && k[3] == 0.0) {
    return wanted;
  }
  Eigen::Vector2d p = radius > 0.0 ? Eigen::Vector2d(wanted * (model.invert(radius, max_radius) / radius))
                                   : Eigen::Vector2d::Zero();
  Eigen::Vector2d error = distorted(k, p) - wanted;
  for (int i = 0; i < 20 && error.squaredNorm() > 1e-28 * (1.0 + radius * radius); ++i) {
    Eigen::Vector2d step = distortionJacobian(k, p).inverse() * error;
    bool better = false;
    for (int half = 0; half < 8 && !better; ++half, step *= 0.5) {
      const Eigen::Vector2d next = p - step;
      const Eigen::Vector2d next_error = distorted(k, next) - wanted;
      better = next.norm() <= max_radius && next_error.squaredNorm() < error.squaredNorm();
      if (better) {
        p = next;
        error = next_error;
      }
    }
    if (!better) {
      break;
    }
  }
  return p;
}

}  // namespace

Camera::Camera(const common::RobotConfig::Intrinsics& intrinsics)
    : fisheye_(intrinsics.model == "fisheye"), width_(intrinsics.width), height_(intrinsics.height) {
  if (!fisheye_ && intrinsics.model != "pinhole") {
    throw common::Error("camera model \"" + intrinsics.model + "\": not known, use pinhole or fisheye");
  }
  const std::vector<double>& k = intrinsics.distortion;
  if (k.size() != 4 && (fisheye_ || k.size() != 5)) {
    throw common::Error("camera model " + intrinsics.model + ": " + std::to_string(k.size()) +
                        " distortion coefficients, needs " +
                        (fisheye_ ? "4 (k1 k2 k3 k4)" : "4 or 5 (k1 k2 p1 p2 [k3])"));
  }
  const auto finite = [](const std::vector<double>& values) {
    return std::all_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); });
  };
  if (intrinsics.focal.size() != 2 || intrinsics.centre.size() != 2 || !finite(intrinsics.focal) ||
      !finite(intrinsics.centre) || !finite(k) || intrinsics.focal[0] <= 0.0 || intrinsics.focal[1] <= 0.0) {
    throw common::Error("camera intrinsics: focal and centre need two finite numbers each, focal positive");
  }
  if (width_ <= 0 || height_ <= 0) {
    throw common::Error("camera intrinsics: width and height must be positive");
  }
  fx_ = intrinsics.focal[0];
  fy_ = intrinsics.focal[1];
  cx_ = intrinsics.centre[0];
  cy_ = intrinsics.centre[1];
  std::copy(k.begin(), k.end(), k_);
  max_radius_ = fisheye_ ? RadialModel{{k_[0], k_[1], k_[2], k_[3]}}.growthLimit(std::numbers::pi)
                         : RadialModel{{k_[0], k_[1], k_[4], 0.0}}.growthLimit(kMaxPinholeRadius);
}

// The conditions are written so that a NaN has no pixel.
std::optional<Eigen::Vector2d> Camera::project(const Eigen::Vector3d& p_camera) const {
  if (!fisheye_) {
    if (!(p_camera.z() > 0.0)) {
      return std::nullopt;
    }
    const Eigen::Vector2d p = p_camera.head<2>() * (1.0 / p_camera.z());
    if (!(p.squaredNorm() <= max_radius_ * max_radius_)) {
      return std::nullopt;
    }
    const Eigen::Vector2d d = distorted(k_, p);
    return Eigen::Vector2d(fx_ * d.x() + cx_, fy_ * d.y() + cy_);
  }
  const double radius = p_camera.head<2>().norm();
  const double norm = p_camera.norm();
  if (!(norm > 0.0 && norm < 1e150) || (radius <= kTinyRadius * norm && p_camera.z() < 0.0)) {
    return std::nullopt;
  }
  if (radius <= kTinyRadius * norm) {
    const Eigen::Vector2d p = p_camera.head<2>() / p_camera.z();
    return Eigen::Vector2d(fx_ * p.x() + cx_, fy_ * p.y() + cy_);
  }
  const double angle = std::atan2(radius, p_camera.z());
  if (!(angle <= max_radius_)) {
    return std::nullopt;
  }
  const double scale = RadialModel{{k_[0], k_[1], k_[2], k_[3]}}.value(angle) / radius;
  return Eigen::Vector2d(fx_ * scale * p_camera.x() + cx_, fy_ * scale * p_camera.y() + cy_);
}

Eigen::Matrix<double, 2, 3> Camera::projectJacobian(const Eigen::Vector3d& p_camera) const {
  Eigen::Matrix<double, 2, 3> J;
  const double z = p_camera.z();
  const double radius = p_camera.head<2>().norm();
  if (!fisheye_) {
    const double inverse_z = 1.0 / z;
    const Eigen::Vector2d p = p_camera.head<2>() * inverse_z;
    J.leftCols<2>() = distortionJacobian(k_, p) * inverse_z;
    J.col(2) = -(J.leftCols<2>() * p);
  } else if (radius <= kTinyRadius * p_camera.norm()) {
    J << 1.0 / z, 0.0, -p_camera.x() / (z * z),  //
        0.0, 1.0 / z, -p_camera.y() / (z * z);
  } else {
    const RadialModel model{{k_[0], k_[1], k_[2], k_[3]}};
    const double angle = std::atan2(radius, z);
    const double slope = model.slope(angle) / p_camera.squaredNorm();
    const double scale = model.value(angle) / radius;
    const Eigen::Vector2d e = p_camera.head<2>() / radius;
    J.leftCols<2>() = scale * Eigen::Matrix2d::Identity() + (slope * z - scale) * e * e.transpose();
    J.col(2) = -slope * radius * e;
  }
  J.row(0) *= fx_;
  J.row(1) *= fy_;
  return J;
}

Eigen::Vector3d Camera::unproject(const Eigen::Vector2d& pixel) const {
  const Eigen::Vector2d p((pixel.x() - cx_) / fx_, (pixel.y() - cy_) / fy_);
  if (!fisheye_) {
    return undistorted(k_, p, max_radius_).homogeneous().normalized();
  }
  const double radius = p.norm();
  if (radius == 0.0) {
    return Eigen::Vector3d::UnitZ();
  }
  const double angle = RadialModel{{k_[0], k_[1], k_[2], k_[3]}}.invert(radius, max_radius_);
  const Eigen::Vector2d e = p * (std::sin(angle) / radius);
  return {e.x(), e.y(), std::cos(angle)};
}

}  // namespace rubble::slam_mono
