#include "marks/sighting.h"

#include <Eigen/Dense>
#include <algorithm>

namespace rubble::fusion {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Of a range that a size tells: corners are a pixel or two off, and prints vary.
constexpr double kSizeSigma = 0.12;
constexpr double kThinnest = 1e-4;

/// The corners, in units of the first one's depth; empty where they are no parallelogram before the camera.
std::optional<std::array<Vector3d, 4>> parallelogram(const std::array<Vector3d, 4>& r) {
  // P0 - P1 + P2 - P3 = 0
  Matrix3d A;
  A << r[1], -r[2], r[3];
  if (std::abs(A.determinant()) < 1e-12) {
    return std::nullopt;
  }
  const Vector3d depth = A.inverse() * r[0];
  if (!depth.allFinite() || depth.minCoeff() < 0.2 || depth.maxCoeff() > 5.0) {
    return std::nullopt;
  }
  return std::array<Vector3d, 4>{r[0], depth[0] * r[1], depth[1] * r[2], depth[2] * r[3]};
}

}  // namespace

Vector3d centreBearing(const std::array<Vector3d, 4>& corners) {
  // Each diagonal spans a plane with the camera; they share the line to the centre.
  const Vector3d mean = corners[0] + corners[1] + corners[2] + corners[3];
  const Vector3d crossing = corners[0].cross(corners[2]).cross(corners[1].cross(corners[3]));
  if (crossing.norm() < kThinnest * kThinnest) {
    return mean.normalized();
  }
  return crossing.dot(mean) > 0.0 ? crossing.normalized() : -crossing.normalized();
}

Vector3d footBearing(const std::array<Vector3d, 4>& corners) {
  constexpr double kUp = 0.25;  // of the box's height
  return (kUp * (corners[0] + corners[1]) + (1.0 - kUp) * (corners[2] + corners[3])).normalized();
}

Vector3d bearingOf(const Sighting& sighting) {
  return sighting.label.isSolid() ? footBearing(sighting.corners) : centreBearing(sighting.corners);
}

std::optional<Matrix3d> faceAttitude(const std::array<Vector3d, 4>& corners) {
  const auto p = parallelogram(corners);
  if (!p) {
    return std::nullopt;
  }
  const Vector3d right = (*p)[1] - (*p)[0] + (*p)[2] - (*p)[3];
  const Vector3d down = (*p)[3] - (*p)[0] + (*p)[2] - (*p)[1];
  const Vector3d out = down.cross(right);
  if (out.norm() < kThinnest || out.dot((*p)[0] + (*p)[2]) > 0.0) {
    return std::nullopt;
  }
  Matrix3d R;
  R.col(0) = right.normalized();
  R.col(2) = out.normalized();
  R.col(1) = R.col(2).cross(R.col(0));
  return R;
}

std::optional<RangeMeasurement> rangeBySize(const Sighting& sighting) {
  const auto p = parallelogram(sighting.corners);
  if (!p || sighting.width <= 0.0 || sighting.height <= 0.0) {
    return std::nullopt;
  }
  // Diagonals keep their length best when the face is slanted and its corners are noisy.
  const double seen = ((*p)[2] - (*p)[0]).norm() + ((*p)[3] - (*p)[1]).norm();
  const double real = 2.0 * std::hypot(sighting.width, sighting.height);
  const double centre = (((*p)[0] + (*p)[2]) / 2.0).norm();
  const double range = real / seen * centre;
  return RangeMeasurement{range, kSizeSigma * range};
}

}  // namespace rubble::fusion
