#include "mono_map_publisher.h"

#include <algorithm>
#include <type_traits>
#include <utility>

#include "lcm_io/conversions.h"
#include "messages.h"

namespace rubble::slam_mono {

namespace {

constexpr int kMessageBytes = 60'000;
/// Repeated per message. At two messages a second 1,000 keyframes and 50,000 points take a minute.
constexpr int kRepeatedKeyframes = 40;
constexpr int kRepeatedPoints = 500;

bool looksTheSame(const Keyframe& a, const Keyframe& b) {
  return a.map_id == b.map_id && a.scale == b.scale && a.parent == b.parent &&
         a.T_camera_mono.matrix() == b.T_camera_mono.matrix();
}

}  // namespace

/// A message that takes what still fits into it.
class MonoMapPublisher::Message {
 public:
  explicit Message(const rubble::mono_map_t& head) : message_(head), bytes_(message_.getEncodedSize()) {}

  template <typename T>
  bool add(std::vector<T>& list, const T& item) {
    int size = sizeof(std::int64_t);
    if constexpr (!std::is_same_v<T, std::int64_t>) {
      size = item.getEncodedSize() - size;  // Without fingerprint.
    }
    if (bytes_ + size > kMessageBytes) {
      return false;
    }
    bytes_ += size;
    list.push_back(item);
    return true;
  }

  /// As many as fit, from the front.
  template <typename T>
  void take(std::deque<T>& queue, std::vector<T>& list) {
    while (!queue.empty() && add(list, queue.front())) {
      queue.pop_front();
    }
  }

  rubble::mono_map_t& operator*() { return message_; }
  rubble::mono_map_t* operator->() { return &message_; }

  rubble::mono_map_t finished() && {
    message_.nkeyframes = static_cast<std::int32_t>(message_.keyframes.size());
    message_.nremoved = static_cast<std::int32_t>(message_.removed.size());
    message_.nframes = static_cast<std::int32_t>(message_.frames.size());
    message_.npoints = static_cast<std::int32_t>(message_.points.size());
    message_.nerased = static_cast<std::int32_t>(message_.erased_points.size());
    return std::move(message_);
  }

 private:
  rubble::mono_map_t message_;
  int bytes_;
};

void MonoMapPublisher::add(const FrameResult& result, const std::shared_ptr<const Map>& map) {
  if (map != map_) {
    noteChanges(*map_, *map);
    map_ = map;
  }
  if (result.keyframe_id != kNoKeyframe) {
    rubble::mono_frame_t frame;
    frame.utime = result.utime;
    frame.keyframe_id = result.keyframe_id;
    frame.keyframe_scale = result.keyframe_scale;
    lcm_io::poseToMessage(result.T_keyframe_camera, frame.p_keyframe_camera, frame.q_keyframe_camera);
    frames_.push_back(frame);
  }
}

void MonoMapPublisher::noteChanges(const Map& before, const Map& now) {
  for (KeyframeId id = 0; id < std::max(before.nextKeyframeId(), now.nextKeyframeId()); ++id) {
    const Keyframe* old = before.keyframe(id);
    const Keyframe* current = now.keyframe(id);
    if (old == current) {  // Shared by both, or in none.
      continue;
    }
    if (current == nullptr) {
      // Both poses of one time: relative to each other they are right, whatever has moved since.
      removed_.push_back(removedMessage(*old, before));
      changed_.erase(id);
    } else if (old == nullptr || !looksTheSame(*old, *current)) {
      changed_.insert(id);
    }
  }
}

rubble::mono_map_t MonoMapPublisher::next(common::Utime utime) {
  rubble::mono_map_t head{};
  head.utime = utime;
  head.revision = map_->revision;
  head.map_keyframes = static_cast<std::int32_t>(map_->keyframeCount());
  head.map_points = static_cast<std::int32_t>(map_->pointCount());
  Message message(head);
  message.take(removed_, message->removed);
  message.take(frames_, message->frames);
  addKeyframes(message);
  addPoints(message);
  return std::move(message).finished();
}

void MonoMapPublisher::addKeyframes(Message& message) {
  while (!changed_.empty() &&
         message.add(message->keyframes, keyframeMessage(*map_->keyframe(*changed_.begin())))) {
    changed_.erase(changed_.begin());
  }
  const std::vector<KeyframeId> ids = map_->keyframes();
  auto id = std::lower_bound(ids.begin(), ids.end(), next_repeated_keyframe_);
  for (std::size_t i = 0; i < std::min<std::size_t>(kRepeatedKeyframes, ids.size()); ++i) {
    id = id == ids.end() ? ids.begin() : id;
    if (!message.add(message->keyframes, keyframeMessage(*map_->keyframe(*id)))) {
      return;
    }
    next_repeated_keyframe_ = *id++ + 1;
  }
}

MonoMapPublisher::SentPoint MonoMapPublisher::pointNow(std::size_t id) const {
  const MapPoint* point = map_->point(static_cast<PointId>(id));
  if (point == nullptr) {
    return {};
  }
  const Eigen::Vector3f p = point->p_mono_point.cast<float>();
  return {true, point->map_id, {p.x(), p.y(), p.z()}};
}

void MonoMapPublisher::addPoints(Message& message) {
  const std::vector<PointId> existing = map_->points();
  if (!existing.empty()) {
    points_.resize(std::max<std::size_t>(points_.size(), existing.back() + 1));
  }
  const auto send = [&](std::size_t id, const SentPoint& now) {
    rubble::mono_map_point_t point;
    point.id = static_cast<std::int64_t>(id);
    point.map_id = now.map_id;
    std::copy(now.p_mono_point.begin(), now.p_mono_point.end(), point.p_mono_point);
    const bool fits =
        now.exists ? message.add(message->points, point) : message.add(message->erased_points, point.id);
    if (fits) {
      points_[id] = now;
    }
    return fits;
  };
  auto id = std::lower_bound(existing.begin(), existing.end(), next_repeated_point_);
  for (std::size_t i = 0; i < std::min<std::size_t>(kRepeatedPoints, existing.size()); ++i) {
    id = id == existing.end() ? existing.begin() : id;
    if (!send(*id, pointNow(*id))) {
      return;
    }
    next_repeated_point_ = *id++ + 1;
  }
  // Goes on where the last message was full, so that no point waits for ever.
  for (std::size_t i = 0; i < points_.size(); ++i) {
    next_changed_point_ = next_changed_point_ < points_.size() ? next_changed_point_ : 0;
    const SentPoint now = pointNow(next_changed_point_);
    if (now != points_[next_changed_point_] && !send(next_changed_point_, now)) {
      return;
    }
    ++next_changed_point_;
  }
}

}  // namespace rubble::slam_mono
