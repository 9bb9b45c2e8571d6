#include "geometry/p3p.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace rubble::slam_mono {
namespace {

constexpr double kMinTriangle = 1e-3;  // twice the area over the longest side's square

/// Ascending real roots of a polynomial of degree Size - 1, lowest coefficient first, between 0 and high: one
/// where the sign changes between neighbouring extrema, which are the derivative's roots.
template <std::size_t Size>
int rootsBetween(const std::array<double, Size>& c, double high, std::array<double, Size>& roots) {
  const auto value = [&](double x) {
    double sum = 0.0;
    for (std::size_t i = Size; i-- > 0;) {
      sum = sum * x + c[i];
    }
    return sum;
  };
  if constexpr (Size == 2) {
    roots[0] = -c[0] / c[1];
    return roots[0] > 0.0 && roots[0] < high ? 1 : 0;
  } else {
    std::array<double, Size - 1> slope{};
    for (std::size_t i = 1; i < Size; ++i) {
      slope[i - 1] = static_cast<double>(i) * c[i];
    }
    std::array<double, Size - 1> extrema{};
    const int extrema_count = rootsBetween(slope, high, extrema);
    int count = 0;
    double a = 0.0;
    double value_a = c[0];
    for (int i = 0; i <= extrema_count; ++i) {
      const double end = i < extrema_count ? extrema[static_cast<std::size_t>(i)] : high;
      const double value_end = value(end);
      if ((value_a < 0.0) != (value_end < 0.0)) {
        // Newton's method inside a bracket; the polynomial is monotonic in it.
        double low = a;
        double up = end;
        double x = 0.5 * (low + up);
        for (int k = 0; k < 60 && up - low > 1e-15 * up; ++k) {
          double f = 0.0;
          double df = 0.0;
          for (std::size_t j = Size; j-- > 0;) {
            df = df * x + f;
            f = f * x + c[j];
          }
          ((f < 0.0) == (value_a < 0.0) ? low : up) = x;
          const double next = x - f / df;
          const double moved = next > low && next < up ? next : 0.5 * (low + up);
          const bool done = std::abs(moved - x) <= 1e-15 * x;
          x = moved;
          if (done) {
            break;
          }
        }
        roots[static_cast<std::size_t>(count++)] = x;
      }
      a = end;
      value_a = value_end;
    }
    return count;
  }
}

/// Axes of a triangle: two congruent ones differ by the rotation between theirs.
Eigen::Matrix3d triangleAxes(const std::array<Eigen::Vector3d, 3>& p) {
  Eigen::Matrix3d axes;
  axes.col(0) = (p[1] - p[0]).normalized();
  axes.col(2) = (p[1] - p[0]).cross(p[2] - p[0]).normalized();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  return axes;
}

/// Newton's method on the three distances takes off what the quartic's coefficients lost.
void polish(const std::array<Eigen::Vector3d, 3>& f, const Eigen::Vector3d& squared, Eigen::Vector3d& s) {
  for (int i = 0; i < 2; ++i) {
    Eigen::Vector3d error;
    Eigen::Matrix3d J = Eigen::Matrix3d::Zero();
    for (int k = 0; k < 3; ++k) {
      const int l = (k + 1) % 3;
      const Eigen::Vector3d d = s[k] * f[static_cast<std::size_t>(k)] - s[l] * f[static_cast<std::size_t>(l)];
      error[k] = d.squaredNorm() - squared[k];
      J(k, k) = 2.0 * d.dot(f[static_cast<std::size_t>(k)]);
      J(k, l) = -2.0 * d.dot(f[static_cast<std::size_t>(l)]);
    }
    const Eigen::Vector3d step = J.inverse() * error;
    if (step.allFinite() && step.norm() < 0.1 * s.norm()) {
      s -= step;
    }
  }
}

}  // namespace

P3pPoses solveP3p(const std::array<Eigen::Vector3d, 3>& points_world,
                  const std::array<Eigen::Vector3d, 3>& bearings) {
  P3pPoses poses;
  const double aa = (points_world[1] - points_world[2]).squaredNorm();
  const double bb = (points_world[0] - points_world[2]).squaredNorm();
  const double cc = (points_world[0] - points_world[1]).squaredNorm();
  const double area = (points_world[1] - points_world[0]).cross(points_world[2] - points_world[0]).norm();
  if (!(area > kMinTriangle * std::max({aa, bb, cc}))) {
    return poses;
  }
  const double cos_a = bearings[1].dot(bearings[2]);
  const double cos_b = bearings[0].dot(bearings[2]);
  const double cos_c = bearings[0].dot(bearings[1]);
  const double a = aa / bb;
  const double c = cc / bb;
  const double d = a - c;
  // In v = s3 / s1, s being the points' distances.
  std::array<double, 5> q = {
      (1.0 + d) * (1.0 + d) - 4.0 * a * cos_c * cos_c,
      4.0 * (-d * (1.0 + d) * cos_b + 2.0 * a * cos_c * cos_c * cos_b - (1.0 - a - c) * cos_a * cos_c),
      2.0 * (d * d - 1.0 + 2.0 * d * d * cos_b * cos_b + 2.0 * (1.0 - c) * cos_a * cos_a -
             4.0 * (a + c) * cos_a * cos_b * cos_c + 2.0 * (1.0 - a) * cos_c * cos_c),
      4.0 * (d * (1.0 - d) * cos_b - (1.0 - a - c) * cos_a * cos_c + 2.0 * c * cos_a * cos_a * cos_b),
      (d - 1.0) * (d - 1.0) - 4.0 * c * cos_a * cos_a};
  std::array<double, 5> roots{};
  const int root_count = rootsBetween(q, 1e3, roots);
  const Eigen::Matrix3d world_axes = triangleAxes(points_world);
  for (int i = 0; i < root_count; ++i) {
    const double v = roots[static_cast<std::size_t>(i)];
    const double u = ((d - 1.0) * v * v - 2.0 * d * cos_b * v + 1.0 + d) / (2.0 * (cos_c - v * cos_a));
    if (!(u > 0.0 && u < 1e3)) {
      continue;
    }
    const double s1 = std::sqrt(bb / (1.0 + v * v - 2.0 * v * cos_b));
    Eigen::Vector3d s(s1, u * s1, v * s1);
    polish(bearings, {cc, aa, bb}, s);
    const std::array<Eigen::Vector3d, 3> points_camera = {s[0] * bearings[0], s[1] * bearings[1],
                                                          s[2] * bearings[2]};
    common::Pose3 T = common::Pose3::Identity();
    T.linear() = triangleAxes(points_camera) * world_axes.transpose();
    T.translation() = points_camera[0] - T.linear() * points_world[0];
    if (T.matrix().allFinite() && s.minCoeff() > 0.0) {
      poses.T_camera_world[static_cast<std::size_t>(poses.count++)] = T;
    }
  }
  return poses;
}

}  // namespace rubble::slam_mono
