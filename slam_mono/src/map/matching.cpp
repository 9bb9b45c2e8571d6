#include "map/matching.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "orb/hamming.h"

namespace rubble::slam_mono {

namespace {

/// A point seen further from the side than this looks different.
constexpr double kMinViewCos = 0.5;
/// Wider search where the view differs: below this the search region grows (ORB-SLAM section V-D).
constexpr double kSameViewCos = 0.998;
constexpr double kSameViewRadius = 2.5;  // pixels
constexpr double kOtherViewRadius = 4.0;

}  // namespace

void LocalPoints::add(PointId id, const MapPoint& point) {
  points.push_back({id, point.p_mono_point, point.normal, point.min_distance, point.max_distance});
  descriptors.push_back(point.descriptor);
}

LocalPoints gatherPoints(const Map& map, std::span<const KeyframeId> keyframes) {
  const std::vector<PointId> ids = map.pointsOf(keyframes);
  LocalPoints local;
  local.points.reserve(ids.size());
  local.descriptors.reserve(ids.size());
  for (const PointId id : ids) {
    local.add(id, *map.point(id));
  }
  return local;
}

std::optional<Sighting> predictSighting(const Camera& camera, const OctaveScales& scales,
                                        const common::Pose3& T_camera_mono,
                                        const Eigen::Vector3d& p_mono_camera, const LocalPoint& point) {
  const Eigen::Vector3d ray = point.p_mono_point - p_mono_camera;
  const double distance = ray.norm();
  if (distance < 0.8 * point.min_distance || distance > 1.2 * point.max_distance) {
    return std::nullopt;
  }
  const double view_cos = ray.dot(point.normal) / distance;
  if (view_cos < kMinViewCos) {
    return std::nullopt;
  }
  const auto pixel = camera.project(T_camera_mono * point.p_mono_point);
  if (!pixel || !camera.contains(*pixel)) {
    return std::nullopt;
  }
  return Sighting{*pixel, scales.predict(point.max_distance, distance), view_cos};
}

void ProjectionMatcher::claim(std::uint32_t feature, PointId point, int distance) {
  if (claims_[feature].point == kNoPoint || distance < claims_[feature].distance) {
    claims_[feature] = {point, distance};
  }
}

int ProjectionMatcher::matchLastFrame(const Map& map, const Frame& last, const PointMatches& last_points,
                                      const Frame& frame, const common::Pose3& T_camera_mono, double radius,
                                      PointMatches& points) {
  claims_.assign(frame.size(), {});
  std::vector<float> last_angle(frame.size());
  for (std::size_t i = 0; i < last.size(); ++i) {
    const MapPoint* point = last_points[i] == kNoPoint ? nullptr : map.point(last_points[i]);
    if (point == nullptr) {
      continue;
    }
    const auto pixel = camera_.project(T_camera_mono * point->p_mono_point);
    if (!pixel || !camera_.contains(*pixel)) {
      continue;
    }
    const int octave = last.features.octave[i];
    candidates_.clear();
    frame.grid.find(frame.features, *pixel, radius * scales_[octave], octave - 1, octave + 1, candidates_);
    const orb::NearestTwo nearest =
        orb::nearestTwo(point->descriptor, frame.features.descriptors, candidates_);
    if (nearest.best_distance <= kLooseDistance) {
      const auto feature = static_cast<std::uint32_t>(nearest.best);
      claim(feature, last_points[i], nearest.best_distance);
      if (claims_[feature].point == last_points[i]) {
        last_angle[feature] = last.features.angle[i];
      }
    }
  }
  std::vector<std::uint32_t> features;
  std::vector<float> turns;
  for (std::uint32_t i = 0; i < frame.size(); ++i) {
    if (claims_[i].point != kNoPoint) {
      features.push_back(i);
      turns.push_back(frame.features.angle[i] - last_angle[i]);
    }
  }
  const std::vector<bool> consistent = consistentTurns(turns);
  int matches = 0;
  points.assign(frame.size(), kNoPoint);
  for (std::size_t k = 0; k < features.size(); ++k) {
    if (consistent[k]) {
      points[features[k]] = claims_[features[k]].point;
      ++matches;
    }
  }
  return matches;
}

int ProjectionMatcher::matchLocalPoints(const LocalPoints& local, const Frame& frame,
                                        const common::Pose3& T_camera_mono, double radius_factor,
                                        int max_distance, double max_ratio, PointMatches& points,
                                        std::vector<PointId>* visible) {
  matched_.clear();
  std::copy_if(points.begin(), points.end(), std::back_inserter(matched_),
               [](PointId p) { return p != kNoPoint; });
  std::sort(matched_.begin(), matched_.end());
  if (visible != nullptr) {
    visible->insert(visible->end(), matched_.begin(), matched_.end());
  }
  claims_.assign(frame.size(), {});
  const Eigen::Vector3d p_mono_camera = T_camera_mono.inverse().translation();
  for (std::size_t k = 0; k < local.size(); ++k) {
    const LocalPoint& point = local.points[k];
    if (std::binary_search(matched_.begin(), matched_.end(), point.id)) {
      continue;
    }
    const auto sighting = predictSighting(camera_, scales_, T_camera_mono, p_mono_camera, point);
    if (!sighting) {
      continue;
    }
    if (visible != nullptr) {
      visible->push_back(point.id);
    }
    const double radius =
        radius_factor * (sighting->view_cos > kSameViewCos ? kSameViewRadius : kOtherViewRadius);
    candidates_.clear();
    frame.grid.find(frame.features, sighting->pixel, radius * scales_[sighting->octave], sighting->octave - 1,
                    sighting->octave + 1, candidates_);
    std::erase_if(candidates_, [&](std::uint32_t i) { return points[i] != kNoPoint; });
    const orb::NearestTwo nearest =
        orb::nearestTwo(local.descriptors[k], frame.features.descriptors, candidates_);
    if (nearest.best_distance > max_distance) {
      continue;
    }
    const auto feature = static_cast<std::uint32_t>(nearest.best);
    // On one octave two corners next to each other compete; on different ones they are the same corner twice.
    if (nearest.second >= 0 &&
        frame.features.octave[feature] == frame.features.octave[static_cast<std::size_t>(nearest.second)] &&
        nearest.best_distance > max_ratio * nearest.second_distance) {
      continue;
    }
    claim(feature, point.id, nearest.best_distance);
  }
  int matches = 0;
  for (std::size_t i = 0; i < frame.size(); ++i) {
    if (claims_[i].point != kNoPoint) {
      points[i] = claims_[i].point;
      ++matches;
    }
  }
  return matches;
}

PointMatches matchExhaustively(const LocalPoints& local, const Frame& frame, int max_distance,
                               double max_ratio) {
  std::vector<orb::NearestTwo> nearest(frame.size());
  orb::nearestTwoOfAll(frame.features.descriptors, local.descriptors, nearest);
  std::vector<std::pair<int, std::size_t>> best_of_point(local.size(), {orb::kNoDistance, 0});
  for (std::size_t i = 0; i < frame.size(); ++i) {
    const orb::NearestTwo& n = nearest[i];
    if (n.best >= 0 && n.best_distance <= max_distance && n.best_distance <= max_ratio * n.second_distance) {
      auto& best = best_of_point[static_cast<std::size_t>(n.best)];
      best = std::min(best, {n.best_distance, i});
    }
  }
  PointMatches points(frame.size(), kNoPoint);
  for (std::size_t k = 0; k < local.size(); ++k) {
    if (best_of_point[k].first < orb::kNoDistance) {
      points[best_of_point[k].second] = local.points[k].id;
    }
  }
  return points;
}

std::vector<bool> consistentTurns(std::span<const float> turns) {
  constexpr int kBins = 30;
  std::array<int, kBins> histogram{};
  const auto binOf = [](float turn) {
    const double turns_of_circle = static_cast<double>(turn) / (2.0 * std::numbers::pi);
    const double share = turns_of_circle - std::floor(turns_of_circle);
    return static_cast<std::size_t>(std::lround(share * kBins)) % kBins;
  };
  for (const float turn : turns) {
    ++histogram[binOf(turn)];
  }
  std::array<int, kBins> sorted = histogram;
  std::nth_element(sorted.begin(), sorted.begin() + 2, sorted.end(), std::greater<>());
  const int third = sorted[2];
  const int first = *std::max_element(histogram.begin(), histogram.end());
  std::vector<bool> consistent;
  consistent.reserve(turns.size());
  for (const float turn : turns) {
    const int count = histogram[binOf(turn)];
    consistent.push_back(count >= third && 10 * count >= first);
  }
  return consistent;
}

std::vector<PointObservation> observationsOf(const Map& map, const Frame& frame, const PointMatches& points,
                                             const OctaveScales& scales,
                                             std::vector<std::uint32_t>& features) {
  std::vector<PointObservation> observations;
  features.clear();
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const MapPoint* point = points[i] == kNoPoint ? nullptr : map.point(points[i]);
    if (point != nullptr) {
      observations.push_back(
          {point->p_mono_point, frame.pixel(i), scales[frame.features.octave[i]], point->uncertainty});
      features.push_back(i);
    }
  }
  return observations;
}

}  // namespace rubble::slam_mono
