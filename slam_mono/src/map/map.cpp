#include "map/map.h"

#include <algorithm>
#include <iterator>
#include <set>
#include <utility>

#include "common/error.h"

namespace rubble::slam_mono {

std::shared_ptr<const Map> Map::snapshot() {
  auto copy = std::make_shared<const Map>(*this);
  ++epoch_;
  return copy;
}

template <typename T>
T& Map::editable(Shared<T>& shared) {
  if (shared.epoch != epoch_) {
    shared.value = std::make_shared<T>(*shared.value);
    shared.epoch = epoch_;
  }
  return *shared.value;
}

const Keyframe* Map::keyframe(KeyframeId id) const {
  return id < 0 || id >= nextKeyframeId() ? nullptr : keyframes_[static_cast<std::size_t>(id)].value.get();
}

const MapPoint* Map::point(PointId id) const {
  if (id >= next_point_) {
    return nullptr;
  }
  const PointBlock* block = blocks_[id / kBlock].value.get();
  return block != nullptr && (*block)[id % kBlock] ? &*(*block)[id % kBlock] : nullptr;
}

Keyframe& Map::edit(KeyframeId id) {
  RUBBLE_CHECK(keyframe(id) != nullptr);
  return editable(keyframes_[static_cast<std::size_t>(id)]);
}

MapPoint& Map::editPoint(PointId id) {
  RUBBLE_CHECK(point(id) != nullptr);
  return *editable(blocks_[id / kBlock])[id % kBlock];
}

std::vector<KeyframeId> Map::keyframes() const {
  std::vector<KeyframeId> ids;
  for (KeyframeId id = 0; id < nextKeyframeId(); ++id) {
    if (keyframe(id) != nullptr) {
      ids.push_back(id);
    }
  }
  return ids;
}

std::vector<PointId> Map::points() const {
  std::vector<PointId> ids;
  ids.reserve(point_count_);
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    if (const PointBlock* block = blocks_[b].value.get()) {
      for (std::size_t i = 0; i < kBlock; ++i) {
        if ((*block)[i]) {
          ids.push_back(static_cast<PointId>(b * kBlock + i));
        }
      }
    }
  }
  return ids;
}

std::vector<PointId> Map::pointsOf(std::span<const KeyframeId> keyframes) const {
  std::vector<PointId> ids;
  for (const KeyframeId id : keyframes) {
    const auto& seen = keyframe(id)->points;
    std::copy_if(seen.begin(), seen.end(), std::back_inserter(ids), [](PointId p) { return p != kNoPoint; });
  }
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  return ids;
}

std::size_t Map::keyframeCount(int map_id) const {
  return static_cast<std::size_t>(
      std::count_if(keyframes_.begin(), keyframes_.end(),
                    [&](const auto& shared) { return shared.value && shared.value->map_id == map_id; }));
}

std::vector<int> Map::mapIds() const {
  std::set<int> ids;
  for (const auto& shared : keyframes_) {
    if (shared.value) {
      ids.insert(shared.value->map_id);
    }
  }
  return {ids.begin(), ids.end()};
}

void Map::skipKeyframeIds(KeyframeId next) {
  keyframes_.resize(std::max(keyframes_.size(), static_cast<std::size_t>(next)));
}

KeyframeId Map::addKeyframe(Keyframe keyframe) {
  keyframe.id = nextKeyframeId();
  keyframe.points.assign(keyframe.frame->size(), kNoPoint);
  keyframes_.push_back({std::make_shared<Keyframe>(std::move(keyframe)), epoch_});
  ++keyframe_count_;
  return nextKeyframeId() - 1;
}

PointId Map::addPoint(MapPoint point) {
  const PointId id = next_point_++;
  if (id / kBlock == blocks_.size()) {
    blocks_.push_back({std::make_shared<PointBlock>(), epoch_});
  } else if (!blocks_.back().value) {
    blocks_.back() = {std::make_shared<PointBlock>(), epoch_};
  }
  editable(blocks_.back())[id % kBlock] = std::move(point);
  ++point_count_;
  return id;
}

void Map::addObservation(PointId point, KeyframeId keyframe, std::uint32_t feature) {
  Keyframe& k = edit(keyframe);
  RUBBLE_CHECK(k.points[feature] == kNoPoint);
  k.points[feature] = point;
  MapPoint& p = editPoint(point);
  p.observations.push_back({keyframe, feature});
  if (p.reference == kNoKeyframe) {
    p.reference = keyframe;
  }
}

void Map::eraseObservation(PointId point, KeyframeId keyframe) {
  MapPoint& p = editPoint(point);
  const auto seen = std::find_if(p.observations.begin(), p.observations.end(),
                                 [&](const Observation& o) { return o.keyframe == keyframe; });
  if (seen == p.observations.end()) {
    return;
  }
  edit(keyframe).points[seen->feature] = kNoPoint;
  p.observations.erase(seen);
  if (p.observations.size() < 2) {
    erasePoint(point);
  } else if (p.reference == keyframe) {
    p.reference = p.observations.front().keyframe;
  }
}

void Map::erasePoint(PointId id) {
  for (const Observation& o : point(id)->observations) {
    edit(o.keyframe).points[o.feature] = kNoPoint;
  }
  eraseSlot(id);
}

void Map::eraseSlot(PointId id) {
  PointBlock& block = editable(blocks_[id / kBlock]);
  block[id % kBlock].reset();
  --point_count_;
  if (std::none_of(block.begin(), block.end(), [](const auto& slot) { return slot.has_value(); })) {
    blocks_[id / kBlock].value.reset();
  }
}

void Map::replacePoint(PointId id, PointId by) {
  RUBBLE_CHECK(id != by);
  const MapPoint old = *point(id);
  for (const Observation& o : old.observations) {
    edit(o.keyframe).points[o.feature] = kNoPoint;
    if (!featureOf(by, o.keyframe)) {
      addObservation(by, o.keyframe, o.feature);
    }
  }
  MapPoint& p = editPoint(by);
  p.visible += old.visible;
  p.found += old.found;
  eraseSlot(id);
}

void Map::eraseKeyframe(KeyframeId id) {
  const Keyframe old = *keyframe(id);
  for (const PointId point : old.points) {
    if (point != kNoPoint && this->point(point) != nullptr) {
      eraseObservation(point, id);
    }
  }
  for (const auto& [other, weight] : old.covisible) {
    if (keyframe(other) != nullptr) {
      std::erase_if(edit(other).covisible, [&](const auto& entry) { return entry.first == id; });
    }
  }
  for (const KeyframeId other : old.loops) {
    if (keyframe(other) != nullptr) {
      std::erase(edit(other).loops, id);
    }
  }
  keyframes_[static_cast<std::size_t>(id)].value.reset();
  --keyframe_count_;
  for (KeyframeId child = 0; child < nextKeyframeId(); ++child) {
    if (const Keyframe* k = keyframe(child); k != nullptr && k->parent == id) {
      // The older neighbours' ids are smaller: a tree stays a tree.
      const auto older = std::find_if(k->covisible.begin(), k->covisible.end(),
                                      [&](const auto& entry) { return entry.first < child; });
      edit(child).parent = older != k->covisible.end() ? older->first : old.parent;
    }
  }
}

std::optional<std::uint32_t> Map::featureOf(PointId point, KeyframeId keyframe) const {
  for (const Observation& o : this->point(point)->observations) {
    if (o.keyframe == keyframe) {
      return o.feature;
    }
  }
  return std::nullopt;
}

std::vector<KeyframeId> Map::neighbours(KeyframeId id, std::size_t n, std::size_t n_second) const {
  std::vector<KeyframeId> found;
  const auto add = [&](KeyframeId other) {
    if (other != id && std::find(found.begin(), found.end(), other) == found.end()) {
      found.push_back(other);
    }
  };
  const auto& first = keyframe(id)->covisible;
  for (std::size_t i = 0; i < std::min(n, first.size()); ++i) {
    add(first[i].first);
  }
  for (std::size_t i = 0; i < std::min(n, first.size()); ++i) {
    const auto& second = keyframe(first[i].first)->covisible;
    for (std::size_t j = 0; j < std::min(n_second, second.size()); ++j) {
      add(second[j].first);
    }
  }
  return found;
}

std::vector<KeyframeId> Map::around(KeyframeId id, std::size_t n) const {
  auto ids = neighbours(id, n);
  ids.push_back(id);
  return ids;
}

double Map::medianDistance(KeyframeId id) const {
  const Keyframe& k = *keyframe(id);
  std::vector<double> distances;
  for (const PointId point : k.points) {
    if (const MapPoint* p = this->point(point)) {
      distances.push_back((k.T_camera_mono * p->p_mono_point).norm());
    }
  }
  if (distances.empty()) {
    return 0.0;
  }
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  return *middle;
}

void Map::transform(int map_id, const Sim3& S_new_old, int new_map_id) {
  const Sim3 S_old_new = S_new_old.inverse();
  for (const KeyframeId id : keyframes()) {
    if (keyframe(id)->map_id == map_id) {
      Keyframe& k = edit(id);
      k.T_camera_mono = (Sim3(k.T_camera_mono) * S_old_new).normalized();
      k.scale *= S_new_old.scale;
      k.map_id = new_map_id;
    }
  }
  for (const PointId id : points()) {
    if (point(id)->map_id == map_id) {
      MapPoint& p = editPoint(id);
      p.p_mono_point = S_new_old * p.p_mono_point;
      p.normal = S_new_old.rotation * p.normal;
      p.uncertainty = S_new_old.scale * (S_new_old.rotation * p.uncertainty);
      p.min_distance *= S_new_old.scale;
      p.max_distance *= S_new_old.scale;
      p.map_id = new_map_id;
    }
  }
}

void Map::eraseMap(int map_id) {
  for (const PointId id : points()) {
    if (point(id)->map_id == map_id) {
      erasePoint(id);
    }
  }
  for (const KeyframeId id : keyframes()) {
    if (keyframe(id)->map_id == map_id) {
      eraseKeyframe(id);
    }
  }
}

}  // namespace rubble::slam_mono
