#include "marks/flatness.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "orb/hamming.h"

namespace rubble::fusion {

namespace {

using Eigen::Vector3d;

constexpr double kViewSpacing = 0.05;  // m
constexpr std::size_t kMostViews = 12;
constexpr std::size_t kMostFeatures = 150;  // of a view
constexpr std::size_t kMostPoints = 400;
// Matches: the tracker's bounds.
constexpr int kFarthest = 64;  // bits
constexpr double kRatio = 0.8;
/// Two bearings that pass each other by more deviations belong to two points.
constexpr double kMeeting = 3.0;
/// A body is 0.1 m thick or more: what tells it from a plane are points that are known better than to a third
/// of that (their bearings being a pixel off, which is more than usual), and a plane is as thick to each side
/// (m).
constexpr double kSharpest = 0.03;
constexpr std::size_t kFewest = 20;  // points
constexpr double kShare = 0.9;       // of the points
/// From the tenth to the ninetieth percent, upwards and sideways: more than the front of one that lies.
constexpr double kExtent = 0.15;  // m
constexpr int kTurns = 90;        // of the plane that are tried, 2 degrees apart

/// Where two bearings meet.
struct Meeting {
  Vector3d p_world = Vector3d::Zero();
  double sigma = 0.0;  // m, along the bearing
};

std::optional<Meeting> meetingOf(const Vector3d& p, const BoxFeature& a, const Vector3d& q,
                                 const BoxFeature& b) {
  const double cosine = a.direction.dot(b.direction);
  const double sine = a.direction.cross(b.direction).norm();
  const double sigma = std::max(a.sigma, b.sigma);
  if (sine <= sigma) {
    return std::nullopt;
  }
  const Vector3d way = q - p;
  const double along_a = (way.dot(a.direction) - cosine * way.dot(b.direction)) / (sine * sine);
  const double along_b = (cosine * way.dot(a.direction) - way.dot(b.direction)) / (sine * sine);
  if (std::min(along_a, along_b) <= 0.0) {
    return std::nullopt;
  }
  const Vector3d on_a = p + along_a * a.direction;
  const Vector3d on_b = q + along_b * b.direction;
  if ((on_a - on_b).norm() > kMeeting * sigma * std::min(along_a, along_b)) {
    return std::nullopt;
  }
  return Meeting{(on_a + on_b) / 2.0, std::max(along_a, along_b) * sigma / sine};
}

struct Nearest {
  std::size_t index = 0;
  bool is_clear = false;
};

Nearest nearestOf(const BoxFeature& query, const std::vector<BoxFeature>& features) {
  Nearest nearest;
  int best = orb::kNoDistance;
  int second = orb::kNoDistance;
  for (std::size_t i = 0; i < features.size(); ++i) {
    const int distance = orb::hammingDistance(query.descriptor, features[i].descriptor);
    if (distance < best) {
      second = best;
      best = distance;
      nearest.index = i;
    } else {
      second = std::min(second, distance);
    }
  }
  nearest.is_clear = best <= kFarthest && best <= kRatio * second;
  return nearest;
}

template <typename T>
void halve(std::vector<T>& values) {
  for (std::size_t i = 0; 2 * i < values.size(); ++i) {
    values[i] = values[2 * i];
  }
  values.resize((values.size() + 1) / 2);
}

double extentOf(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const auto quantile = [&](double q) {
    return values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1))];
  };
  return quantile(0.9) - quantile(0.1);
}

/// The points in the upright plane across `normal` that holds most of them.
std::vector<Vector3d> inPlane(const Vector3d& normal, std::vector<Vector3d> points) {
  std::sort(points.begin(), points.end(),
            [&](const Vector3d& a, const Vector3d& b) { return normal.dot(a) < normal.dot(b); });
  std::size_t first = 0;
  std::size_t most = 0;
  for (std::size_t begin = 0, end = 0; begin < points.size(); ++begin) {
    while (end < points.size() && normal.dot(points[end] - points[begin]) <= 2.0 * kSharpest) {
      ++end;
    }
    if (end - begin > most) {
      first = begin;
      most = end - begin;
    }
  }
  const auto from = points.begin() + static_cast<std::ptrdiff_t>(first);
  return {from, from + static_cast<std::ptrdiff_t>(most)};
}

}  // namespace

void FlatnessCheck::add(FeatureView view) {
  while (view.features.size() > kMostFeatures) {
    halve(view.features);
  }
  match(view);
  if (std::all_of(views_.begin(), views_.end(), [&](const FeatureView& kept) {
        return (kept.p_world_camera - view.p_world_camera).norm() >= kViewSpacing;
      })) {
    if (views_.size() == kMostViews) {
      halve(views_);
    }
    views_.push_back(std::move(view));
  }
}

void FlatnessCheck::match(const FeatureView& view) {
  std::vector<std::optional<Meeting>> sharpest(view.features.size());
  for (const FeatureView& kept : views_) {
    for (std::size_t i = 0; i < view.features.size(); ++i) {
      const BoxFeature& feature = view.features[i];
      const Nearest there = nearestOf(feature, kept.features);
      if (!there.is_clear || nearestOf(kept.features[there.index], view.features).index != i) {
        continue;
      }
      const auto meeting =
          meetingOf(view.p_world_camera, feature, kept.p_world_camera, kept.features[there.index]);
      if (meeting && meeting->sigma <= kSharpest && (!sharpest[i] || meeting->sigma < sharpest[i]->sigma)) {
        sharpest[i] = meeting;
      }
    }
  }
  for (const auto& meeting : sharpest) {
    if (meeting) {
      points_.push_back(meeting->p_world);
    }
  }
  while (points_.size() > kMostPoints) {
    halve(points_);
  }
}

bool FlatnessCheck::isFlat() const {
  if (points_.size() < kFewest) {
    return false;
  }
  for (int i = 0; i < kTurns; ++i) {
    const double angle = i * std::numbers::pi / kTurns;
    const Vector3d normal(std::cos(angle), std::sin(angle), 0.0);
    const std::vector<Vector3d> flat = inPlane(normal, points_);
    if (static_cast<double>(flat.size()) < kShare * static_cast<double>(points_.size())) {
      continue;
    }
    std::vector<double> sideways;
    std::vector<double> upwards;
    for (const Vector3d& p : flat) {
      sideways.push_back(normal.x() * p.y() - normal.y() * p.x());
      upwards.push_back(p.z());
    }
    if (extentOf(std::move(sideways)) >= kExtent && extentOf(std::move(upwards)) >= kExtent) {
      return true;
    }
  }
  return false;
}

}  // namespace rubble::fusion
