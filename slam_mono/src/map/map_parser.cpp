#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <utility>

#include "common/byte_stream.h"
#include "map/map_file.h"

namespace rubble::slam_mono {

namespace {

/// More are damage: they would take all memory.
constexpr std::uint64_t kMostKeyframes = 1U << 22U;
constexpr std::uint64_t kMostPoints = 1U << 28U;
constexpr std::size_t kFeatureBytes = 3 * sizeof(float) + 1 + sizeof(orb::Descriptor);
constexpr std::size_t kObservationBytes = sizeof(KeyframeId) + sizeof(std::uint32_t);

Eigen::Vector3d getVector(common::ByteReader& in) {
  const auto v = in.get<std::array<double, 3>>();
  return {v[0], v[1], v[2]};
}

template <typename T>
void getCounted(common::ByteReader& in, std::vector<T>& values) {
  values.resize(in.getCount(sizeof(T)));
  in.getAll(std::span(values));
}

bool isRotation(const Eigen::Matrix3d& R) {
  return (R * R.transpose() - Eigen::Matrix3d::Identity()).norm() < 1e-6 && R.determinant() > 0.0;
}

}  // namespace

/// Builds a map with its ids as they were.
class MapParser {
 public:
  MapParser(std::span<const std::uint8_t> bytes, const Camera& camera, int levels)
      : in_(bytes, "monocular map"), camera_(camera), levels_(levels) {}

  Map parse();

 private:
  std::shared_ptr<const Frame> getFrame();
  void getKeyframe();
  void getPoint();
  void observe(PointId id, const MapPoint& point);
  void checkLinks();
  void checkTree();
  void require(bool ok, const char* what) const {
    if (!ok) {
      in_.fail(fmt::format("{} {}: {}", kind_, id_, what));
    }
  }
  void about(const char* kind, std::int64_t id) {
    kind_ = kind;
    id_ = id;
  }

  common::ByteReader in_;
  const Camera& camera_;
  const int levels_;
  Map map_;
  // What is being read, for errors.
  const char* kind_ = "";
  std::int64_t id_ = 0;
};

std::shared_ptr<const Frame> MapParser::getFrame() {
  const auto utime = in_.get<common::Utime>();
  orb::Features f;
  f.width = in_.get<int>();
  f.height = in_.get<int>();
  require(f.width == camera_.width() && f.height == camera_.height(),
          "its picture's size is not the camera's");
  const std::size_t count = in_.getCount(kFeatureBytes);
  f.x.resize(count);
  f.y.resize(count);
  f.angle.resize(count);
  f.octave.resize(count);
  f.descriptors.resize(count);
  in_.getAll(std::span(f.x));
  in_.getAll(std::span(f.y));
  in_.getAll(std::span(f.angle));
  in_.getAll(std::span(f.octave));
  in_.getAll(std::span(f.descriptors));
  for (std::size_t i = 0; i < count; ++i) {
    require(camera_.contains({static_cast<double>(f.x[i]), static_cast<double>(f.y[i])}),
            "a feature outside the picture");
    require(std::isfinite(f.angle[i]), "a feature's orientation is not finite");
    require(f.octave[i] < levels_, "a feature's octave is not among the pyramid's levels");
  }
  return std::make_shared<const Frame>(utime, std::move(f), camera_);
}

void MapParser::getKeyframe() {
  Keyframe k;
  k.id = in_.get<KeyframeId>();
  require(k.id > id_ && k.id < map_.nextKeyframeId(), "the next one's id is out of order");
  about("keyframe", k.id);
  k.map_id = in_.get<int>();
  require(k.map_id > 0, "map id not positive");
  k.frame = getFrame();
  for (int row = 0; row < 3; ++row) {
    k.T_camera_mono.linear().row(row) = getVector(in_).transpose();
  }
  k.T_camera_mono.translation() = getVector(in_);
  require(isRotation(k.T_camera_mono.linear()) && k.T_camera_mono.translation().allFinite(), "not a pose");
  k.scale = in_.get<double>();
  require(std::isfinite(k.scale) && k.scale > 0.0, "scale not positive");
  k.parent = in_.get<KeyframeId>();
  k.covisible.resize(in_.getCount(sizeof(KeyframeId) + sizeof(int)));
  for (auto& [id, weight] : k.covisible) {
    id = in_.get<KeyframeId>();
    weight = in_.get<int>();
  }
  getCounted(in_, k.loops);
  k.points.assign(k.frame->size(), kNoPoint);
  const auto slot = static_cast<std::size_t>(k.id);
  map_.keyframes_[slot] = {std::make_shared<Keyframe>(std::move(k)), map_.epoch_};
  ++map_.keyframe_count_;
}

void MapParser::getPoint() {
  const auto id = in_.get<PointId>();
  require(id > id_ && id < map_.next_point_, "the next one's id is out of order");
  about("point", id);
  MapPoint p;
  p.map_id = in_.get<int>();
  p.p_mono_point = getVector(in_);
  p.uncertainty = getVector(in_);
  p.normal = getVector(in_);
  p.min_distance = in_.get<double>();
  p.max_distance = in_.get<double>();
  require(p.p_mono_point.allFinite() && p.uncertainty.allFinite() && p.normal.allFinite(),
          "position, uncertainty or normal not finite");
  require(p.min_distance >= 0.0 && p.max_distance >= p.min_distance && std::isfinite(p.max_distance),
          "impossible distances");
  p.descriptor = in_.get<orb::Descriptor>();
  p.reference = in_.get<KeyframeId>();
  p.first = in_.get<KeyframeId>();
  require(p.first >= kNoKeyframe && p.first < map_.nextKeyframeId(), "made by an impossible keyframe");
  p.visible = in_.get<int>();
  p.found = in_.get<int>();
  require(p.visible >= 0 && p.found >= 0, "seen a negative number of times");
  p.observations.resize(in_.getCount(kObservationBytes));
  for (Observation& o : p.observations) {
    o.keyframe = in_.get<KeyframeId>();
    o.feature = in_.get<std::uint32_t>();
  }
  observe(id, p);
  auto& block = map_.blocks_[id / Map::kBlock];
  if (!block.value) {
    block = {std::make_shared<Map::PointBlock>(), map_.epoch_};
  }
  (*block.value)[id % Map::kBlock] = std::move(p);
  ++map_.point_count_;
}

void MapParser::observe(PointId id, const MapPoint& point) {
  bool reference_sees_it = false;
  for (std::size_t i = 0; i < point.observations.size(); ++i) {
    const Observation& o = point.observations[i];
    require(map_.keyframe(o.keyframe) != nullptr, "seen by a keyframe that does not exist");
    Keyframe& k = map_.edit(o.keyframe);
    require(k.map_id == point.map_id, "seen by a keyframe of another map");
    require(o.feature < k.points.size(), "seen as a feature that its keyframe does not have");
    require(k.points[o.feature] == kNoPoint, "seen as a feature that shows another point");
    require(
        std::none_of(point.observations.begin(), point.observations.begin() + static_cast<std::ptrdiff_t>(i),
                     [&](const Observation& other) { return other.keyframe == o.keyframe; }),
        "seen twice by one keyframe");
    k.points[o.feature] = id;
    reference_sees_it |= o.keyframe == point.reference;
  }
  require(reference_sees_it, "its reference does not see it");
}

void MapParser::checkLinks() {
  const auto exists = [&](KeyframeId id, const Keyframe& of) {
    const Keyframe* other = map_.keyframe(id);
    return other != nullptr && other != &of && other->map_id == of.map_id;
  };
  for (const KeyframeId id : map_.keyframes()) {
    about("keyframe", id);
    const Keyframe& k = *map_.keyframe(id);
    require(k.parent == kNoKeyframe || exists(k.parent, k), "its parent is not a keyframe of its map");
    std::vector<KeyframeId> others;
    for (const auto& [other, weight] : k.covisible) {
      require(exists(other, k), "its neighbour is not a keyframe of its map");
      require(weight > 0, "shares no points with a neighbour");
      const auto& theirs = map_.keyframe(other)->covisible;
      require(std::find(theirs.begin(), theirs.end(), std::pair(id, weight)) != theirs.end(),
              "its neighbour does not know it alike");
      others.push_back(other);
    }
    std::sort(others.begin(), others.end());
    require(std::adjacent_find(others.begin(), others.end()) == others.end(), "has a neighbour twice");
    for (const KeyframeId other : k.loops) {
      require(exists(other, k), "its loop leads to none of its map's keyframes");
    }
  }
}

void MapParser::checkTree() {
  enum class Mark : std::uint8_t { kUnknown, kOnTheWay, kLeadsToRoot };
  std::vector<Mark> marks(map_.keyframes_.size(), Mark::kUnknown);
  std::vector<KeyframeId> way;
  for (const KeyframeId id : map_.keyframes()) {
    about("keyframe", id);
    way.clear();
    KeyframeId at = id;
    while (at != kNoKeyframe && marks[static_cast<std::size_t>(at)] != Mark::kLeadsToRoot) {
      require(marks[static_cast<std::size_t>(at)] == Mark::kUnknown, "is its own ancestor");
      marks[static_cast<std::size_t>(at)] = Mark::kOnTheWay;
      way.push_back(at);
      at = map_.keyframe(at)->parent;
    }
    for (const KeyframeId passed : way) {
      marks[static_cast<std::size_t>(passed)] = Mark::kLeadsToRoot;
    }
  }
}

Map MapParser::parse() {
  in_.openSealed(kMapMagic, "a map");
  map_.revision = in_.get<std::int64_t>();
  const auto next_keyframe = in_.get<std::uint64_t>();
  const auto next_point = in_.get<std::uint64_t>();
  if (next_keyframe > kMostKeyframes || next_point > kMostPoints) {
    in_.fail("impossibly many keyframes or points");
  }
  map_.keyframes_.resize(next_keyframe);
  map_.next_point_ = static_cast<PointId>(next_point);
  map_.blocks_.resize((next_point + Map::kBlock - 1) / Map::kBlock);
  about("keyframe", -1);
  for (std::size_t left = in_.getCount(sizeof(KeyframeId)); left > 0; --left) {
    getKeyframe();
  }
  about("point", -1);
  for (std::size_t left = in_.getCount(sizeof(PointId)); left > 0; --left) {
    getPoint();
  }
  checkLinks();
  checkTree();
  if (in_.left() != 0) {
    in_.fail("there is more than belongs to it");
  }
  return std::move(map_);
}

Map parseMap(std::span<const std::uint8_t> bytes, const Camera& camera, int levels) {
  return MapParser(bytes, camera, levels).parse();
}

}  // namespace rubble::slam_mono
