#include "map/places.h"

#include <algorithm>
#include <map>

#include "orb/hamming.h"

namespace rubble::slam_mono {

namespace {

constexpr std::size_t kSample = 300;  // features that are asked for their nearest point
constexpr std::size_t kMostPoints = 60'000;
constexpr int kMaxDistance = 60;    // bits
constexpr double kMaxRatio = 0.85;  // NNDR
constexpr int kCandidates = 2;      // of its nearest points that a feature may vote for

}  // namespace

void PlaceTable::update(const std::shared_ptr<const Map>& map) {
  if (map == map_) {
    return;
  }
  map_ = map;
  ids_ = map->points();
  if (const std::size_t step = 1 + ids_.size() / kMostPoints; step > 1) {
    std::erase_if(ids_, [&](PointId id) { return id % step != 0; });
  }
  descriptors_.clear();
  descriptors_.reserve(ids_.size());
  for (const PointId id : ids_) {
    descriptors_.push_back(map->point(id)->descriptor);
  }
}

std::vector<Place> PlaceTable::recognise(const Frame& frame, const std::function<bool(const Keyframe&)>& skip,
                                         std::size_t most) const {
  std::vector<bool> skipped(static_cast<std::size_t>(map_->nextKeyframeId()), true);
  bool any = false;
  for (const KeyframeId id : map_->keyframes()) {
    skipped[static_cast<std::size_t>(id)] = skip(*map_->keyframe(id));
    any |= !skipped[static_cast<std::size_t>(id)];
  }
  if (!any) {
    return {};
  }
  std::vector<orb::Descriptor> descriptors;
  std::vector<const MapPoint*> points;
  for (std::size_t i = 0; i < ids_.size(); ++i) {
    const MapPoint* point = map_->point(ids_[i]);
    if (std::none_of(point->observations.begin(), point->observations.end(),
                     [&](const Observation& o) { return skipped[static_cast<std::size_t>(o.keyframe)]; })) {
      descriptors.push_back(descriptors_[i]);
      points.push_back(point);
    }
  }
  // Features on coarse octaves are seen from further away: every n-th of all, so that each octave has its
  // share.
  const std::size_t step = std::max<std::size_t>(1, frame.size() / kSample);
  std::vector<orb::Descriptor> sample;
  for (std::size_t i = 0; i < frame.size(); i += step) {
    sample.push_back(frame.features.descriptors[i]);
  }
  std::vector<orb::NearestTwo> nearest(sample.size());
  orb::nearestTwoOfAll(sample, descriptors, nearest);

  std::map<KeyframeId, double> votes;
  for (const orb::NearestTwo& n : nearest) {
    if (n.best < 0 || n.best_distance > kMaxDistance) {
      continue;
    }
    // Both count where the ratio cannot tell them apart: they may be one place mapped twice.
    const int count = n.second >= 0 && n.best_distance > kMaxRatio * n.second_distance ? kCandidates : 1;
    const std::array<int, kCandidates> found{n.best, n.second};
    for (int c = 0; c < count; ++c) {
      for (const Observation& o :
           points[static_cast<std::size_t>(found[static_cast<std::size_t>(c)])]->observations) {
        votes[o.keyframe] += 1.0 / count;
      }
    }
  }
  std::vector<Place> sorted;
  for (const auto& [keyframe, count] : votes) {
    sorted.push_back({keyframe, count});
  }
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const Place& a, const Place& b) { return a.votes > b.votes; });
  std::vector<Place> places;
  std::vector<KeyframeId> covered;
  for (const Place& place : sorted) {
    if (places.size() == most) {
      break;
    }
    if (std::find(covered.begin(), covered.end(), place.keyframe) == covered.end()) {
      places.push_back(place);
      const auto around = map_->neighbours(place.keyframe, 15);
      covered.insert(covered.end(), around.begin(), around.end());
    }
  }
  return places;
}

}  // namespace rubble::slam_mono
