#include "tracking/tracker.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "common/error.h"

namespace rubble::slam_mono {

namespace {

constexpr int kFewMatches = 20;        // from the last frame; below it the search is widened
constexpr int kMinMotionInliers = 10;  // after the last frame's points; the local map has to bring the rest
constexpr double kWiden = 2.0;
constexpr int kMaxLocalAge = 5;  // frames for which the local points are kept
constexpr std::size_t kMostLocalKeyframes = 60;
constexpr double kFirm = 0.2;             // of its distance, a point's uncertainty that tells a translation
constexpr std::size_t kMinFeatures = 50;  // in a picture that shows anything
constexpr double kWideRadius = 3.0;       // factor of the local search right after a relocalisation
constexpr double kYoungMap = 10.0;        // s for which a new map looks for an older one at every frame
constexpr std::size_t kAroundPlace = 20;  // neighbours of a recognised keyframe whose points are matched

/// The motion over another time, at constant speed.
common::Pose3 scaled(const common::Pose3& T, double factor) {
  const Eigen::AngleAxisd turn(T.linear());
  common::Pose3 result = common::Pose3::Identity();
  result.linear() = Eigen::AngleAxisd(turn.angle() * factor, turn.axis()).toRotationMatrix();
  result.translation() = T.translation() * factor;
  return result;
}

Eigen::Matrix<double, 6, 6> unknownCovariance() {
  return Eigen::Matrix<double, 6, 6>::Identity() * std::numeric_limits<double>::infinity();
}

}  // namespace

Tracker::Tracker(const Camera& camera, const OctaveScales& scales, const MonoSlamConfig& config)
    : camera_(camera),
      scales_(scales),
      config_(config),
      matcher_(camera, scales),
      initializer_(camera, scales, config.start),
      relocaliser_(camera, scales) {}

void Tracker::expectNear(KeyframeId keyframe) {
  state_ = TrackingState::kLost;
  last_.reset();
  velocity_.reset();
  local_reference_ = keyframe;
  local_age_ = kMaxLocalAge;
}

std::vector<FrameResult> Tracker::begin(const Map& map, KeyframeId second) {
  const Keyframe& k = *map.keyframe(second);
  const Keyframe& first = *map.keyframe(k.parent);
  expectNear(second);
  // Backwards from the second view, each frame next to one that is known.
  std::vector<FrameResult> located{locatedAt(map, k.frame->utime, k, k.T_camera_mono, {})};
  last_ = Last{k.frame, k.points, RelativePose::of(k, k.T_camera_mono), k.T_camera_mono};
  for (auto frame = between_.rbegin(); frame != between_.rend(); ++frame) {
    const auto match = matchFrom(**frame, map, last_->T_camera_mono, kWiden * config_.tracking.search_radius);
    if (!match || match->inliers < config_.tracking.min_inliers) {
      break;
    }
    located.push_back(locatedAt(map, (*frame)->utime, k, match->T_camera_mono, match->covariance));
    last_ = Last{*frame, match->points, {}, match->T_camera_mono};
  }
  if (located.size() == between_.size() + 1) {
    located.push_back(locatedAt(map, first.frame->utime, first, first.T_camera_mono, {}));
  }
  std::reverse(located.begin(), located.end());
  between_.clear();

  state_ = TrackingState::kTracking;
  tracked_since_ = k.frame->utime;
  last_ = Last{k.frame, k.points, RelativePose::of(k, k.T_camera_mono), k.T_camera_mono};
  velocity_ = k.T_camera_mono * first.T_camera_mono.inverse();
  velocity_time_ = k.frame->utime - first.frame->utime;
  return located;
}

FrameResult Tracker::locatedAt(const Map& map, common::Utime utime, const Keyframe& reference,
                               const common::Pose3& T_camera_mono,
                               const std::optional<Eigen::Matrix<double, 6, 6>>& covariance) {
  FrameResult result;
  result.utime = utime;
  result.state = TrackingState::kTracking;
  result.map_id = reference.map_id;
  result.map_revision = map.revision;
  result.T_mono_camera = T_camera_mono.inverse();
  result.covariance = covariance.value_or(unknownCovariance());
  const RelativePose pose = RelativePose::of(reference, T_camera_mono);
  result.keyframe_id = pose.reference;
  result.T_keyframe_camera = pose.T_camera_reference.inverse();
  result.keyframe_scale = pose.reference_scale;
  return result;
}

Tracker::Output Tracker::track(const std::shared_ptr<const Frame>& frame,
                               const std::shared_ptr<const Map>& map, bool mapper_free) {
  std::optional<Match> match;
  bool relocalised = false;
  if (map->keyframeCount() > 0 && frame->size() >= kMinFeatures) {
    if (state_ == TrackingState::kTracking) {
      match = trackMotion(frame, *map);
    }
    if (!match) {
      match = relocalise(*frame, map);
      relocalised = match.has_value();
    } else if (common::secondsFromUtime(frame->utime - tracked_since_) < kYoungMap) {
      if (auto older = seekOlderMap(*frame, map)) {
        match = std::move(older);
        relocalised = true;
      }
    }
  }

  Output output;
  FrameResult& result = output.result;
  result.covariance = match ? match->covariance : unknownCovariance();
  const bool tracked = match.has_value();
  if (tracked) {
    if (relocalised) {
      velocity_.reset();
      last_.reset();
    }
    if (state_ != TrackingState::kTracking) {
      tracked_since_ = frame->utime;
    }
    state_ = TrackingState::kTracking;
    initializer_.reset();
    accept(frame, *map, std::move(*match));
    if (needsKeyframe(*frame, *map, mapper_free)) {
      output.request = requestKeyframe();
    }
  } else {
    if (state_ == TrackingState::kTracking) {
      state_ = TrackingState::kLost;
      lost_since_ = frame->utime;
    }
    const double lost_for = common::secondsFromUtime(frame->utime - lost_since_);
    const bool may_start =
        state_ == TrackingState::kInitializing || lost_for > config_.tracking.new_map_after;
    if (may_start && mapper_free && !config_.localisation_only) {
      if (auto start = initializer_.addFrame(frame)) {
        between_ = start->between;
        output.request = std::move(*start);
      }
    }
  }

  result.utime = frame->utime;
  result.state = state_;
  result.map_revision = map->revision;
  if (last_) {
    result.T_mono_camera = last_->T_camera_mono.inverse();
    if (const Keyframe* reference = map->keyframe(last_->pose.reference)) {
      result.map_id = reference->map_id;
    }
  }
  if (tracked) {
    result.inliers = inliers_;
    result.keyframe_id = last_->pose.reference;
    result.T_keyframe_camera = last_->pose.T_camera_reference.inverse();
    result.keyframe_scale = last_->pose.reference_scale;
  }
  return output;
}

std::optional<common::Pose3> Tracker::lastPose(const Map& map) const {
  if (!last_) {
    return std::nullopt;
  }
  const Keyframe* reference = map.keyframe(last_->pose.reference);
  // A reference that was culled takes no correction along: the pose as it was is the best there is.
  return reference != nullptr ? last_->pose.T_camera_mono(*reference) : last_->T_camera_mono;
}

std::optional<Tracker::Match> Tracker::matchFrom(const Frame& frame, const Map& map,
                                                 const common::Pose3& T_camera_mono, double radius) {
  Match match;
  if (matcher_.matchLastFrame(map, *last_->frame, last_->points, frame, T_camera_mono, radius, match.points) <
      kFewMatches) {
    return std::nullopt;
  }
  match = optimise(frame, map, T_camera_mono, std::move(match.points));
  return match.inliers >= kMinMotionInliers ? std::optional(std::move(match)) : std::nullopt;
}

std::optional<Tracker::Match> Tracker::trackMotion(const std::shared_ptr<const Frame>& frame,
                                                   const Map& map) {
  const auto T_last_mono = lastPose(map);
  if (!T_last_mono) {
    return std::nullopt;
  }
  common::Pose3 T_camera_mono = *T_last_mono;
  if (velocity_ && velocity_time_ > 0) {
    const double steps = common::secondsFromUtime(frame->utime - last_->frame->utime) /
                         common::secondsFromUtime(velocity_time_);
    T_camera_mono = scaled(*velocity_, std::min(steps, 3.0)) * T_camera_mono;
  }
  const double radius = config_.tracking.search_radius;
  auto match = matchFrom(*frame, map, T_camera_mono, radius);
  if (!match) {
    match = matchFrom(*frame, map, T_camera_mono, kWiden * radius);
  }
  if (!match) {
    match = matchFrom(*frame, map, *T_last_mono, 2.0 * kWiden * radius);
  }
  if (!match) {
    return std::nullopt;
  }
  return refine(*frame, map, *match, config_.tracking.min_inliers, 1.0);
}

Tracker::Match Tracker::optimise(const Frame& frame, const Map& map, const common::Pose3& T_camera_mono,
                                 PointMatches points) const {
  std::vector<std::uint32_t> features;
  const auto observations = observationsOf(map, frame, points, scales_, features);
  const PoseOptimum optimum = optimizePose(camera_, T_camera_mono, observations);
  for (std::size_t k = 0; k < features.size(); ++k) {
    if (!optimum.inliers[k]) {
      points[features[k]] = kNoPoint;
    }
  }
  return {optimum.T_camera_mono, std::move(points), optimum.covariance, optimum.inlier_count};
}

std::optional<Tracker::Match> Tracker::refine(const Frame& frame, const Map& map, const Match& start,
                                              int min_inliers, double radius_factor) {
  updateLocal(map, start.points);
  PointMatches points = start.points;
  std::vector<PointId> visible;
  matcher_.matchLocalPoints(local_, frame, start.T_camera_mono, radius_factor, kLooseDistance, 0.8, points,
                            &visible);
  Match match = optimise(frame, map, start.T_camera_mono, std::move(points));
  if (match.inliers < min_inliers) {
    return std::nullopt;
  }
  statistics_.visible.insert(statistics_.visible.end(), visible.begin(), visible.end());
  std::copy_if(match.points.begin(), match.points.end(), std::back_inserter(statistics_.found),
               [](PointId p) { return p != kNoPoint; });
  return match;
}

void Tracker::updateLocal(const Map& map, const PointMatches& points) {
  std::vector<int> votes(static_cast<std::size_t>(map.nextKeyframeId()), 0);
  std::vector<KeyframeId> keyframes;
  for (const PointId id : points) {
    if (const MapPoint* point = id == kNoPoint ? nullptr : map.point(id)) {
      for (const Observation& o : point->observations) {
        if (votes[static_cast<std::size_t>(o.keyframe)]++ == 0) {
          keyframes.push_back(o.keyframe);
        }
      }
    }
  }
  if (keyframes.empty()) {
    return;
  }
  std::sort(keyframes.begin(), keyframes.end(), [&](KeyframeId a, KeyframeId b) {
    const int va = votes[static_cast<std::size_t>(a)];
    const int vb = votes[static_cast<std::size_t>(b)];
    return va != vb ? va > vb : a < b;
  });
  const KeyframeId reference = keyframes.front();
  if (reference == local_reference_ && local_epoch_ == map.epoch() && ++local_age_ < kMaxLocalAge) {
    return;
  }
  local_reference_ = reference;
  local_epoch_ = map.epoch();
  local_age_ = 0;
  const std::size_t voted = std::min<std::size_t>(keyframes.size(), kMostLocalKeyframes);
  keyframes.resize(voted);
  for (std::size_t i = 0; i < voted && keyframes.size() < kMostLocalKeyframes; ++i) {
    for (const KeyframeId other : map.neighbours(keyframes[i], 10)) {
      if (votes[static_cast<std::size_t>(other)] == 0 && keyframes.size() < kMostLocalKeyframes) {
        votes[static_cast<std::size_t>(other)] = 1;
        keyframes.push_back(other);
      }
    }
  }
  local_ = gatherPoints(map, keyframes);
}

std::optional<Tracker::Match> Tracker::relocalise(const Frame& frame, const std::shared_ptr<const Map>& map) {
  const int min_inliers = config_.tracking.relocalisation_inliers;
  const auto confirm = [&](const LocalPoints& local) -> std::optional<Match> {
    auto pose = relocaliser_.match(frame, *map, local);
    if (!pose) {
      return std::nullopt;
    }
    local_age_ = kMaxLocalAge;
    const Match start{pose->T_camera_mono, std::move(pose->points), {}, 0};
    // Twice: what the first search brings makes the pose good enough for the second.
    const auto wide = refine(frame, *map, start, kFewMatches, kWideRadius);
    return wide ? refine(frame, *map, *wide, min_inliers, 1.0) : std::nullopt;
  };
  const Keyframe* reference = map->keyframe(local_reference_);
  if (reference != nullptr) {
    if (auto match = confirm(gatherPoints(*map, map->around(reference->id, kAroundPlace)))) {
      return match;
    }
  }
  for (const Place& place : relocaliser_.places(frame, map)) {
    if (auto match = confirm(gatherPoints(*map, map->around(place.keyframe, kAroundPlace)))) {
      return match;
    }
  }
  return std::nullopt;
}

std::optional<Tracker::Match> Tracker::seekOlderMap(const Frame& frame,
                                                    const std::shared_ptr<const Map>& map) {
  const Keyframe* reference = map->keyframe(local_reference_);
  if (reference == nullptr || map->keyframeCount() == map->keyframeCount(reference->map_id)) {
    return std::nullopt;
  }
  const LocalPoints local_before = local_;
  for (const Place& place : relocaliser_.places(frame, map, reference->map_id)) {
    const LocalPoints local = gatherPoints(*map, map->around(place.keyframe, kAroundPlace));
    if (auto pose = relocaliser_.match(frame, *map, local)) {
      local_age_ = kMaxLocalAge;
      const Match start{pose->T_camera_mono, std::move(pose->points), {}, 0};
      if (auto match = refine(frame, *map, start, config_.tracking.relocalisation_inliers, kWideRadius)) {
        return match;
      }
    }
  }
  local_ = local_before;
  local_reference_ = reference->id;
  return std::nullopt;
}

void Tracker::accept(const std::shared_ptr<const Frame>& frame, const Map& map, Match match) {
  const auto T_last_mono = lastPose(map);
  if (T_last_mono) {
    velocity_ = match.T_camera_mono * T_last_mono->inverse();
    velocity_time_ = frame->utime - last_->frame->utime;
  }
  inliers_ = match.inliers;
  const Keyframe& reference = *map.keyframe(local_reference_);
  last_ = Last{frame, std::move(match.points), RelativePose::of(reference, match.T_camera_mono),
               match.T_camera_mono};
}

bool Tracker::needsKeyframe(const Frame& frame, const Map& map, bool mapper_free) const {
  if (config_.localisation_only || !mapper_free) {
    return false;
  }
  const double since = common::secondsFromUtime(frame.utime - last_keyframe_);
  if (since < config_.tracking.min_keyframe_interval) {
    return false;
  }
  const Keyframe& reference = *map.keyframe(local_reference_);
  const std::size_t enough = map.keyframeCount(reference.map_id) <= 2 ? 2 : 3;
  // Those that tell the translation, of the points of a view.
  const auto firm = [&](const PointMatches& points, const common::Pose3& T_camera_mono) {
    return static_cast<double>(std::count_if(points.begin(), points.end(), [&](PointId id) {
      const MapPoint* p = id == kNoPoint ? nullptr : map.point(id);
      return p != nullptr && p->observations.size() >= enough &&
             p->uncertainty.norm() < kFirm * (T_camera_mono * p->p_mono_point).norm();
    }));
  };
  const double share = since > config_.tracking.max_keyframe_interval
                           ? 1.0 - 0.5 * (1.0 - config_.tracking.keyframe_share)
                           : config_.tracking.keyframe_share;
  return firm(last_->points, last_->T_camera_mono) < share * firm(reference.points, reference.T_camera_mono);
}

MapRequest Tracker::requestKeyframe() {
  last_keyframe_ = last_->frame->utime;
  return NewKeyframe{last_->frame, last_->points, last_->pose, std::exchange(statistics_, {})};
}

}  // namespace rubble::slam_mono
