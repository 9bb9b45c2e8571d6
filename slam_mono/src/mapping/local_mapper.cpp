#include "mapping/local_mapper.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "common/error.h"
#include "mapping/keyframe_culling.h"
#include "orb/hamming.h"

namespace rubble::slam_mono {

namespace {

constexpr BundleEffort kStartEffort{30, 1e-6};
constexpr std::size_t kMinStartPoints = 40;
constexpr std::size_t kTinyMap = 5;      // keyframes
constexpr double kMinFoundShare = 0.25;  // of the frames that should see a point
constexpr double kMinBaseline = 0.005;   // of the median distance, of two keyframes that make points
constexpr double kFarthest = 100.0;      // median distances, of a new point
constexpr KeyframeId kKeptNewest = 5;    // keyframes that are not culled: the tracker leans on them
constexpr KeyframeId kLocal = 20;        // keyframes, of which local mapping needs every one

}  // namespace

LocalMapper::LocalMapper(const Camera& camera, const OctaveScales& scales, const MonoSlamConfig& config)
    : camera_(camera), scales_(scales), config_(config), matcher_(camera, scales) {}

void LocalMapper::replaceMap(Map map) {
  map_ = std::move(map);
  recent_.clear();
}

std::optional<KeyframeId> LocalMapper::start(const NewMap& request) {
  std::map<int, std::size_t> sizes;
  for (const KeyframeId id : map_.keyframes()) {
    ++sizes[map_.keyframe(id)->map_id];
  }
  for (const auto& [map_id, size] : sizes) {
    if (size < kTinyMap) {
      map_.eraseMap(map_id);
    }
  }
  recent_.clear();
  const int map_id = map_.nextKeyframeId() + 1;  // As unique as keyframes are, and positive.
  const KeyframeId first = map_.addKeyframe(
      {.map_id = map_id, .frame = request.first, .points = {}, .covisible = {}, .loops = {}});
  const KeyframeId second = map_.addKeyframe({.map_id = map_id,
                                              .frame = request.second,
                                              .T_camera_mono = request.T_second_first,
                                              .points = {},
                                              .covisible = {},
                                              .loops = {}});
  for (const NewMap::Pair& pair : request.pairs) {
    MapPoint point;
    point.map_id = map_id;
    point.p_mono_point = pair.p_first;
    point.first = second;
    const PointId id = map_.addPoint(std::move(point));
    map_.addObservation(id, first, pair.first);
    map_.addObservation(id, second, pair.second);
    map_.refreshPoint(id, scales_);
  }
  const std::array moving{second};
  const std::array fixed{first};
  BundleProblem problem = makeBundle(map_, moving, fixed, map_.pointsOf(moving), scales_);
  solveBundle(camera_, problem, kStartEffort);
  applyBundle(map_, problem, scales_);
  const auto seen = map_.keyframe(second)->points;
  const double distance = map_.medianDistance(second);
  if (std::count_if(seen.begin(), seen.end(), [](PointId p) { return p != kNoPoint; }) <
          static_cast<std::ptrdiff_t>(kMinStartPoints) ||
      !(distance > 0.0)) {
    map_.eraseMap(map_id);
    return std::nullopt;
  }
  map_.transform(map_id, Sim3(Eigen::Quaterniond::Identity(), Eigen::Vector3d::Zero(), 1.0 / distance),
                 map_id);
  map_.refreshCovisibility(second);
  for (const PointId id : seen) {
    if (id != kNoPoint) {
      recent_.push_back(id);
    }
  }
  return second;
}

std::optional<KeyframeId> LocalMapper::insert(const NewKeyframe& request, bool with_adjustment) {
  const Keyframe* reference = map_.keyframe(request.pose.reference);
  countStatistics(request.statistics);
  if (reference == nullptr) {
    return std::nullopt;
  }
  Keyframe made;
  made.map_id = reference->map_id;
  made.frame = request.frame;
  made.T_camera_mono = request.pose.T_camera_mono(*reference);
  made.scale = reference->scale;
  made.parent = kNoKeyframe;
  const KeyframeId id = map_.addKeyframe(std::move(made));
  for (std::uint32_t i = 0; i < request.points.size(); ++i) {
    const PointId point = request.points[i];
    if (point != kNoPoint && map_.point(point) != nullptr &&
        map_.point(point)->map_id == map_.keyframe(id)->map_id && !map_.featureOf(point, id)) {
      map_.addObservation(point, id, i);
      map_.refreshPoint(point, scales_);
    }
  }
  map_.refreshCovisibility(id);
  if (map_.keyframe(id)->parent == kNoKeyframe) {
    map_.edit(id).parent = request.pose.reference;
  }
  cullPoints(id);
  triangulate(id);
  fuseNeighbours(id);
  if (with_adjustment) {
    adjust(id);
  }
  cullKeyframes(id);
  return id;
}

void LocalMapper::countStatistics(const PointStatistics& statistics) {
  for (const PointId id : statistics.visible) {
    if (map_.point(id) != nullptr) {
      ++map_.editPoint(id).visible;
    }
  }
  for (const PointId id : statistics.found) {
    if (map_.point(id) != nullptr) {
      ++map_.editPoint(id).found;
    }
  }
}

void LocalMapper::cullPoints(KeyframeId newest) {
  std::erase_if(recent_, [&](PointId id) {
    const MapPoint* p = map_.point(id);
    if (p == nullptr) {
      return true;
    }
    const KeyframeId age = newest - p->first;
    if (p->found < kMinFoundShare * p->visible || (age >= 2 && p->observations.size() <= 2)) {
      map_.erasePoint(id);
      return true;
    }
    return age >= 3;
  });
}

void LocalMapper::triangulate(KeyframeId newest) {
  const double distance = map_.medianDistance(newest);
  for (const KeyframeId other :
       map_.neighbours(newest, static_cast<std::size_t>(config_.mapping.neighbours))) {
    const double baseline =
        (map_.keyframe(newest)->p_mono_camera() - map_.keyframe(other)->p_mono_camera()).norm();
    if (baseline > kMinBaseline * distance) {
      triangulateWith(newest, other, kFarthest * distance);
    }
  }
}

void LocalMapper::triangulateWith(KeyframeId newest, KeyframeId other, double farthest) {
  const Keyframe& a = *map_.keyframe(newest);
  const Keyframe& b = *map_.keyframe(other);
  const common::Pose3 T_b_a = b.T_camera_mono * a.T_camera_mono.inverse();
  const common::Pose3 T_mono_a = a.T_camera_mono.inverse();
  const auto unmatched = [](const Keyframe& k) {
    std::vector<std::uint32_t> features;
    for (std::uint32_t i = 0; i < k.points.size(); ++i) {
      if (k.points[i] == kNoPoint) {
        features.push_back(i);
      }
    }
    return features;
  };
  const auto features_a = unmatched(a);
  const auto features_b = unmatched(b);
  // Bearings side by side for the sweep over all pairs.
  Eigen::Matrix<float, 3, Eigen::Dynamic> bearings_b(3, static_cast<Eigen::Index>(features_b.size()));
  for (std::size_t j = 0; j < features_b.size(); ++j) {
    bearings_b.col(static_cast<Eigen::Index>(j)) = b.frame->bearings[features_b[j]].cast<float>();
  }
  const Eigen::Vector3d epipole = T_b_a.translation().normalized();

  struct Claim {
    int distance = orb::kNoDistance;
    std::uint32_t feature = 0;
  };
  std::vector<Claim> claims(features_b.size());
  std::vector<std::uint32_t> candidates;
  std::vector<std::size_t> candidate_index;
  Eigen::VectorXf off_plane(static_cast<Eigen::Index>(features_b.size()));
  for (const std::uint32_t i : features_a) {
    // Of the plane through both centres and the feature, in b.
    const Eigen::Vector3d ray = T_b_a.linear() * a.frame->bearings[i];
    const Eigen::Vector3d normal = epipole.cross(ray);
    const double sine = normal.norm();
    if (sine < 0.02) {
      continue;  // Next to the epipole every feature fits.
    }
    off_plane.noalias() = bearings_b.transpose() * (normal / sine).cast<float>();
    const int octave_a = a.frame->features.octave[i];
    candidates.clear();
    candidate_index.clear();
    for (std::size_t j = 0; j < features_b.size(); ++j) {
      const int octave_b = b.frame->features.octave[features_b[j]];
      const double limit = 2.0 * scales_.angle(octave_b);
      if (static_cast<double>(std::abs(off_plane[static_cast<Eigen::Index>(j)])) < limit &&
          std::abs(octave_a - octave_b) <= 3) {
        candidates.push_back(features_b[j]);
        candidate_index.push_back(j);
      }
    }
    const orb::NearestTwo n =
        orb::nearestTwo(a.frame->features.descriptors[i], b.frame->features.descriptors, candidates);
    if (n.best_distance > kStrictDistance) {
      continue;
    }
    const auto j = candidate_index[static_cast<std::size_t>(
        std::find(candidates.begin(), candidates.end(), static_cast<std::uint32_t>(n.best)) -
        candidates.begin())];
    if (n.best_distance < claims[j].distance) {
      claims[j] = {n.best_distance, i};
    }
  }

  std::vector<float> turns;
  std::vector<std::size_t> claimed;
  for (std::size_t j = 0; j < claims.size(); ++j) {
    if (claims[j].distance < orb::kNoDistance) {
      claimed.push_back(j);
      turns.push_back(b.frame->features.angle[features_b[j]] - a.frame->features.angle[claims[j].feature]);
    }
  }
  const std::vector<bool> consistent = consistentTurns(turns);
  for (std::size_t k = 0; k < claimed.size(); ++k) {
    if (!consistent[k]) {
      continue;
    }
    const std::uint32_t i = claims[claimed[k]].feature;
    const std::uint32_t j = features_b[claimed[k]];
    const Keyframe& now_a = *map_.keyframe(newest);
    const Keyframe& now_b = *map_.keyframe(other);
    // No parallax is too small, or noise would choose the points that it brings nearer, and with them the
    // scale would shrink in every turn. What meets behind or nowhere is as far as anything, if both pixels
    // allow that.
    auto p_a = slam_mono::triangulate(T_b_a, now_a.frame->bearings[i], now_b.frame->bearings[j]);
    if (!p_a || p_a->norm() > farthest) {
      p_a = farthest * now_a.frame->bearings[i];
    }
    const Eigen::Vector3d p_b = T_b_a * *p_a;
    const auto fits = [&](const Frame& frame, const Eigen::Vector3d& p, std::uint32_t feature) {
      const double sigma = scales_[frame.features.octave[feature]];
      const auto pixel = camera_.project(p);
      return pixel && (*pixel - frame.pixel(feature)).squaredNorm() < kChi2Two * sigma * sigma;
    };
    if (!fits(*now_a.frame, *p_a, i) || !fits(*now_b.frame, p_b, j)) {
      continue;
    }
    // Distances and octaves have to tell the same story.
    const double distances = p_b.norm() / p_a->norm();
    const double octaves =
        scales_[now_a.frame->features.octave[i]] / scales_[now_b.frame->features.octave[j]];
    const double tolerance = 1.5 * scales_.factor();
    if (distances > octaves * tolerance || distances * tolerance < octaves) {
      continue;
    }
    MapPoint point;
    point.map_id = now_a.map_id;
    point.p_mono_point = T_mono_a * *p_a;
    point.first = newest;
    const PointId id = map_.addPoint(std::move(point));
    map_.addObservation(id, newest, i);
    map_.addObservation(id, other, j);
    map_.refreshPoint(id, scales_);
    recent_.push_back(id);
  }
}

void LocalMapper::fuse(KeyframeId keyframe, const LocalPoints& points, double radius_factor) {
  // The frame as if it had no matches: a feature that has a point and matches another shows a duplicate.
  PointMatches matches(map_.keyframe(keyframe)->frame->size(), kNoPoint);
  const common::Pose3 T_camera_mono = map_.keyframe(keyframe)->T_camera_mono;
  const std::shared_ptr<const Frame> frame = map_.keyframe(keyframe)->frame;
  matcher_.matchLocalPoints(points, *frame, T_camera_mono, radius_factor, kStrictDistance, 1.0, matches,
                            nullptr);
  for (std::uint32_t i = 0; i < matches.size(); ++i) {
    const PointId id = matches[i];
    if (id == kNoPoint || map_.point(id) == nullptr || map_.featureOf(id, keyframe)) {
      continue;
    }
    const double sigma = scales_[frame->features.octave[i]];
    const auto pixel = camera_.project(T_camera_mono * map_.point(id)->p_mono_point);
    if (!pixel || (*pixel - frame->pixel(i)).squaredNorm() > kChi2Two * sigma * sigma * radius_factor) {
      continue;
    }
    const PointId present = map_.keyframe(keyframe)->points[i];
    if (present == kNoPoint) {
      map_.addObservation(id, keyframe, i);
    } else if (map_.point(present)->observations.size() > map_.point(id)->observations.size()) {
      map_.replacePoint(id, present);
    } else {
      map_.replacePoint(present, id);
    }
  }
}

void LocalMapper::fuseNeighbours(KeyframeId newest) {
  const auto neighbours = map_.neighbours(newest, static_cast<std::size_t>(config_.mapping.neighbours), 5);
  const std::array self{newest};
  for (const KeyframeId other : neighbours) {
    // Gathered again each time: fusing replaces points.
    fuse(other, gatherPoints(map_, self), 1.0);
  }
  fuse(newest, gatherPoints(map_, neighbours), 1.0);
  for (const PointId id : map_.keyframe(newest)->points) {
    if (id != kNoPoint) {
      map_.refreshPoint(id, scales_);
    }
  }
  map_.refreshCovisibility(newest);
}

void LocalMapper::adjust(KeyframeId newest) {
  std::vector<KeyframeId> moving = map_.neighbours(newest, static_cast<std::size_t>(config_.mapping.window));
  moving.push_back(newest);
  // Who else sees these points holds the window in place, the most common first.
  std::map<KeyframeId, int> shared;
  std::set<PointId> seen;
  for (const KeyframeId id : moving) {
    for (const PointId point : map_.keyframe(id)->points) {
      if (point != kNoPoint && seen.insert(point).second) {
        for (const Observation& o : map_.point(point)->observations) {
          ++shared[o.keyframe];
        }
      }
    }
  }
  std::vector<std::pair<int, KeyframeId>> others;
  for (const auto& [id, count] : shared) {
    if (std::find(moving.begin(), moving.end(), id) == moving.end()) {
      others.emplace_back(-count, id);
    }
  }
  std::sort(others.begin(), others.end());
  std::vector<KeyframeId> fixed;
  for (std::size_t i = 0; i < std::min(others.size(), static_cast<std::size_t>(config_.mapping.fixed)); ++i) {
    fixed.push_back(others[i].second);
  }
  // Something has to hold position, attitude and scale: two keyframes at least.
  std::sort(moving.begin(), moving.end());
  while (fixed.size() < 2 && moving.size() > 1) {
    fixed.push_back(moving.front());
    moving.erase(moving.begin());
  }
  BundleProblem problem = makeBundle(map_, moving, fixed, map_.pointsOf(moving), scales_);
  solveBundle(camera_, problem, {.iterations = config_.mapping.iterations});
  applyBundle(map_, problem, scales_);
}

void LocalMapper::cullKeyframes(KeyframeId newest) {
  const auto covisible = map_.keyframe(newest)->covisible;
  for (const auto& [id, weight] : covisible) {
    const Keyframe& k = *map_.keyframe(id);
    if (k.parent == kNoKeyframe || id > newest - kKeptNewest || !k.loops.empty()) {
      continue;
    }
    if (othersSeeItsPoints(map_, k, config_.mapping.redundant_share) ||
        (id <= newest - kLocal && othersHaveItsView(map_, k))) {
      map_.eraseKeyframe(id);
    }
  }
}

}  // namespace rubble::slam_mono
