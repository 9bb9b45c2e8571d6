#include "joint/point_scale.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

namespace rubble::fusion {

using common::Pose3;
using Eigen::Vector3d;

namespace {

/// Points this near the scan's plane (m) stand on what the scan sees: walls are upright.
constexpr double kOffPlane = 0.10;
/// Ranges that are used, m; and by how much (share) the beams beside may differ: edges tell nothing.
constexpr double kNearest = 0.4;
constexpr double kFarthest = 6.0;
constexpr double kSmooth = 0.03;
constexpr std::ptrdiff_t kBeside = 2;  // beams
/// Points before the camera: tangents of their angles off its axis.
constexpr double kWidest = 0.8;
constexpr double kSteepest = 0.3;
/// The range is looked up again where the scaled point lies.
constexpr int kLookups = 3;
constexpr double kFirstGuess = 2.0;  // m
/// How the logarithms lie about the scale: most within kSpread, points behind what the LiDAR sees below it,
/// wrong ones anywhere.
constexpr double kSpread = 0.02;
constexpr double kBehind = 0.7;  // Of the most, at the scale.
constexpr double kDepth = 0.06;  // Falls by e over this.
constexpr double kAnywhere = 0.1;
/// The scale is sought so far from where it is taken to be, in such steps; by values that far from there; and
/// so many have to lie within three times kSpread of it.
constexpr double kReach = 0.1;
constexpr double kStep = 0.0025;
constexpr double kRegion = 0.3;
constexpr std::ptrdiff_t kLeastPoints = 8;

std::optional<double> rangeAt(const RangeScan& scan, double angle) {
  const auto i = static_cast<std::ptrdiff_t>(std::lround((angle - scan.first_angle) / scan.angle_step));
  if (i < kBeside || i + kBeside >= static_cast<std::ptrdiff_t>(scan.ranges.size())) {
    return std::nullopt;
  }
  const auto range = [&](std::ptrdiff_t k) {
    return static_cast<double>(scan.ranges[static_cast<std::size_t>(k)]);
  };
  if (!(range(i) >= kNearest && range(i) <= kFarthest)) {
    return std::nullopt;
  }
  for (std::ptrdiff_t k = i - kBeside; k <= i + kBeside; ++k) {
    if (!(std::abs(range(k) - range(i)) < kSmooth * range(i))) {
      return std::nullopt;
    }
  }
  return range(i);
}

/// The scale at which p (in units of the map, in `camera`) lies where the scan ends.
std::optional<double> scaleOf(const Vector3d& p, const Pose3& T_lidar_camera, const RangeScan& scan) {
  const Vector3d d = T_lidar_camera.linear() * p;
  const Vector3d& o = T_lidar_camera.translation();
  double scale = kFirstGuess / d.norm();
  for (int i = 0; i < kLookups; ++i) {
    const Vector3d q = scale * d + o;
    const auto range = rangeAt(scan, std::atan2(q.y(), q.x()));
    if (!range) {
      return std::nullopt;
    }
    // |scale d + o| = range in the scan's plane.
    const double a = d.head<2>().squaredNorm();
    const double b = d.head<2>().dot(o.head<2>());
    const double c = o.head<2>().squaredNorm() - *range * *range;
    scale = (-b + std::sqrt(std::max(b * b - a * c, 0.0))) / a;
  }
  return std::abs(scale * d.z() + o.z()) <= kOffPlane ? std::optional(scale) : std::nullopt;
}

/// Values of a sorted list within `width` of `middle`.
auto within(const std::vector<double>& values, double middle, double width) {
  return std::pair(std::lower_bound(values.begin(), values.end(), middle - width),
                   std::upper_bound(values.begin(), values.end(), middle + width));
}

double densest(const std::vector<double>& values) {
  double best = values.front();
  std::ptrdiff_t most = 0;
  for (const double value : values) {
    const auto [first, last] = within(values, value, kSpread);
    if (last - first > most) {
      most = last - first;
      best = value;
    }
  }
  return best;
}

double logLikelihood(double deviation) {
  const double near = std::exp(-0.5 * deviation * deviation / (kSpread * kSpread));
  const double behind = deviation < 0.0 ? std::exp(deviation / kDepth) : near;
  return std::log(near + kBehind * behind + kAnywhere);
}

/// The most likely scale near `middle`; empty where the likelihood only rises.
std::optional<double> mostLikely(const std::vector<double>& logs, double middle) {
  const auto [first, last] = within(logs, middle, kRegion);
  const auto at = [&, first = first, last = last](double scale) {
    return std::accumulate(first, last, 0.0,
                           [&](double sum, double log) { return sum + logLikelihood(log - scale); });
  };
  const int steps = static_cast<int>(kReach / kStep);
  int best = 0;
  double most = -std::numeric_limits<double>::infinity();
  for (int i = -steps; i <= steps; ++i) {
    if (const double likelihood = at(middle + i * kStep); likelihood > most) {
      most = likelihood;
      best = i;
    }
  }
  return std::abs(best) < steps ? std::optional(middle + best * kStep) : std::nullopt;
}

}  // namespace

void PointScale::set(std::int64_t id, std::int32_t map_id, const Vector3d& p_mono) {
  points_[id] = {map_id, p_mono};
}

std::optional<double> PointScale::measure(std::int32_t map_id, const Pose3& T_mono_camera,
                                          const Pose3& T_camera_lidar, const RangeScan& scan,
                                          std::optional<double> guess) const {
  const Pose3 T_camera_mono = T_mono_camera.inverse();
  const Pose3 T_lidar_camera = T_camera_lidar.inverse();
  std::vector<double> logs;
  for (const auto& [id, point] : points_) {
    const Vector3d p = T_camera_mono * point.p_mono;
    if (point.map_id != map_id || std::abs(p.x()) > kWidest * p.z() || std::abs(p.y()) > kSteepest * p.z()) {
      continue;
    }
    const auto scale = scaleOf(p, T_lidar_camera, scan);
    if (scale && *scale > 0.0) {
      logs.push_back(std::log(*scale));
    }
  }
  if (logs.empty()) {
    return std::nullopt;
  }
  // No median, nor a mode: points behind what the LiDAR sees lie below the scale.
  std::sort(logs.begin(), logs.end());
  const auto scale = mostLikely(logs, guess ? *guess : densest(logs));
  if (!scale) {
    return std::nullopt;
  }
  const auto [first, last] = within(logs, *scale, 3.0 * kSpread);
  return last - first >= kLeastPoints ? scale : std::nullopt;
}

}  // namespace rubble::fusion
