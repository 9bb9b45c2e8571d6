#include "loop/loop_closer.h"

#include <algorithm>
#include <set>
#include <utility>

namespace rubble::slam_mono {

namespace {

constexpr std::size_t kPlaces = 3;
constexpr std::size_t kAround = 15;    // neighbours whose points belong to a place
constexpr KeyframeId kRest = 10;       // keyframes after a closure without another
constexpr double kSearchRadius = 3.0;  // factor of the guided search
constexpr int kMaxDistance = 60;
constexpr double kMaxRatio = 0.85;    // NNDR
constexpr double kSimilarTurn = 0.1;  // rad, between two keyframes' corrections
constexpr double kSimilarScale = 1.15;
constexpr double kSimilarShift = 0.25;  // of the median distance
constexpr double kMaxTurn = 0.5;        // rad, that drift may have come to
constexpr double kMaxScale = 2.0;
constexpr int kRegions = 4;             // along each side of the picture
constexpr std::size_t kMinRegions = 5;  // in which the place agrees
constexpr KeyframeId kMostBetween = 3;  // keyframes between two that confirm each other

}  // namespace

LoopCloser::LoopCloser(const Camera& camera, const OctaveScales& scales, const MonoSlamConfig::Loop& config)
    : camera_(camera), scales_(scales), config_(config), matcher_(camera, scales) {}

std::optional<LoopClosure> LoopCloser::detect(const std::shared_ptr<const Map>& map, KeyframeId keyframe) {
  const Keyframe* k = map->keyframe(keyframe);
  if (!config_.enabled || k == nullptr) {
    return std::nullopt;
  }
  const bool resting = last_closed_ != kNoKeyframe && keyframe < last_closed_ + kRest;
  std::set<KeyframeId> connected{keyframe};
  for (const auto& [other, weight] : k->covisible) {
    connected.insert(other);
  }
  table_.update(map);
  const auto places = table_.recognise(
      *k->frame,
      [&](const Keyframe& other) {
        return connected.contains(other.id) || (other.map_id == k->map_id && resting);
      },
      kPlaces);
  for (const Place& place : places) {
    if (place.votes < config_.min_votes) {
      break;
    }
    if (auto found = verify(*map, keyframe, place.keyframe)) {
      if (!confirm(*map, *found)) {
        return std::nullopt;
      }
      last_closed_ = keyframe;
      return found;
    }
  }
  return std::nullopt;
}

std::optional<LoopClosure> LoopCloser::verify(const Map& map, KeyframeId keyframe, KeyframeId place) {
  const Keyframe& a = *map.keyframe(keyframe);
  const Keyframe& b = *map.keyframe(place);
  auto around = map.neighbours(place, kAround);
  std::erase_if(around, [&](KeyframeId id) {
    return std::any_of(a.covisible.begin(), a.covisible.end(),
                       [&](const auto& entry) { return entry.first == id; });
  });
  around.push_back(place);
  const LocalPoints local = gatherPoints(map, around);
  const auto pairsOf = [&](const PointMatches& matches) {
    std::vector<PointPair> pairs;
    for (std::uint32_t i = 0; i < matches.size(); ++i) {
      const PointId own = a.points[i];
      if (matches[i] == kNoPoint || own == kNoPoint || own == matches[i]) {
        continue;
      }
      const Eigen::Vector3d p_b = b.T_camera_mono * map.point(matches[i])->p_mono_point;
      // Where a neighbour of the place sees the point and the place does not, its projection stands for it.
      const auto seen = map.featureOf(matches[i], place);
      const auto pixel_b = seen ? std::optional(b.frame->pixel(*seen)) : camera_.project(p_b);
      if (!pixel_b) {
        continue;
      }
      const double sigma = scales_[a.frame->features.octave[i]];
      pairs.push_back({a.T_camera_mono * map.point(own)->p_mono_point, p_b, a.frame->pixel(i), *pixel_b,
                       sigma, seen ? scales_[b.frame->features.octave[*seen]] : sigma});
    }
    return pairs;
  };
  Sim3Config config;
  config.min_inliers = config_.min_inliers;
  const auto first =
      solveSim3(camera_, pairsOf(matchExhaustively(local, *a.frame, kMaxDistance, kMaxRatio)), config);
  if (!first) {
    return std::nullopt;
  }
  // The place's points as the keyframe's map would have them, to be searched for in the keyframe.
  const auto search = [&](const Sim3& S_a_b, std::vector<PointId>* visible) {
    const Sim3 S_here_place = Sim3(a.T_camera_mono).inverse() * S_a_b * Sim3(b.T_camera_mono);
    LocalPoints moved = local;
    for (LocalPoint& p : moved.points) {
      p.p_mono_point = S_here_place * p.p_mono_point;
      p.normal = S_here_place.rotation * p.normal;
      p.min_distance *= S_here_place.scale;
      p.max_distance *= S_here_place.scale;
    }
    PointMatches matches(a.frame->size(), kNoPoint);
    matcher_.matchLocalPoints(moved, *a.frame, a.T_camera_mono, kSearchRadius, kLooseDistance, 0.9, matches,
                              visible);
    return matches;
  };
  const auto pairs = pairsOf(search(first->S_a_b, nullptr));
  if (pairs.size() < static_cast<std::size_t>(config_.min_inliers)) {
    return std::nullopt;
  }
  const Sim3Result refined = refineSim3(camera_, pairs, first->S_a_b, config.max_error);
  if (refined.inlier_count < config_.min_inliers) {
    return std::nullopt;
  }
  std::vector<PointId> visible;
  const PointMatches matches = search(refined.S_a_b, &visible);
  int good = 0;
  std::set<std::pair<int, int>> regions;  // of the picture that agree
  for (std::uint32_t i = 0; i < matches.size(); ++i) {
    if (matches[i] == kNoPoint) {
      continue;
    }
    const Eigen::Vector3d p_b = b.T_camera_mono * map.point(matches[i])->p_mono_point;
    const auto pixel = camera_.project(refined.S_a_b * p_b);
    const double sigma = scales_[a.frame->features.octave[i]];
    if (pixel && (*pixel - a.frame->pixel(i)).squaredNorm() < 1.5 * kChi2Two * sigma * sigma) {
      ++good;
      regions.emplace(static_cast<int>(a.frame->pixel(i).x()) * kRegions / camera_.width(),
                      static_cast<int>(a.frame->pixel(i).y()) * kRegions / camera_.height());
    }
  }
  // A repeated sign on a strange wall agrees, too: what should be seen beside it tells the difference.
  if (good < config_.min_matches || good < config_.min_share * static_cast<double>(visible.size()) ||
      regions.size() < kMinRegions) {
    return std::nullopt;
  }
  const Sim3 S_place_keyframe =
      Sim3(b.T_camera_mono).inverse() * refined.S_a_b.inverse() * Sim3(a.T_camera_mono);
  if (a.map_id == b.map_id && !plausibleDrift(map, a, b, S_place_keyframe)) {
    return std::nullopt;
  }
  return LoopClosure{keyframe, place, S_place_keyframe};
}

bool LoopCloser::plausibleDrift(const Map& map, const Keyframe& keyframe, const Keyframe& place,
                                const Sim3& S_place_keyframe) const {
  double way = 0.0;
  Eigen::Vector3d last = place.p_mono_camera();
  const auto [first_id, last_id] = std::minmax(place.id, keyframe.id);
  for (KeyframeId id = first_id; id <= last_id; ++id) {
    if (const Keyframe* k = map.keyframe(id); k != nullptr && k->map_id == keyframe.map_id) {
      way += id == first_id ? 0.0 : (k->p_mono_camera() - last).norm();
      last = k->p_mono_camera();
    }
  }
  const Eigen::Vector3d here = keyframe.p_mono_camera();
  const double scale = std::max(S_place_keyframe.scale, 1.0 / S_place_keyframe.scale);
  return (S_place_keyframe * here - here).norm() < config_.max_drift * way &&
         Eigen::AngleAxisd(S_place_keyframe.rotation).angle() < kMaxTurn && scale < kMaxScale;
}

bool LoopCloser::confirm(const Map& map, const LoopClosure& found) {
  const Keyframe& k = *map.keyframe(found.keyframe);
  bool same = false;
  if (pending_ && map.keyframe(pending_->keyframe) != nullptr && map.keyframe(pending_->place) != nullptr &&
      found.keyframe - pending_->keyframe <= kMostBetween &&
      map.keyframe(pending_->keyframe)->map_id == k.map_id &&
      map.keyframe(pending_->place)->map_id == map.keyframe(found.place)->map_id) {
    const Eigen::Vector3d here = k.p_mono_camera();
    const Sim3 difference = pending_->S_place_keyframe.inverse() * found.S_place_keyframe;
    const double ratio = std::max(difference.scale, 1.0 / difference.scale);
    same = Eigen::AngleAxisd(difference.rotation).angle() < kSimilarTurn && ratio < kSimilarScale &&
           (difference * here - here).norm() < kSimilarShift * map.medianDistance(found.keyframe);
  }
  confirmations_ = same ? confirmations_ + 1 : 1;
  pending_ = found;
  if (confirmations_ < config_.confirmations) {
    return false;
  }
  pending_.reset();
  confirmations_ = 0;
  return true;
}

}  // namespace rubble::slam_mono
