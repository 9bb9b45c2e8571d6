#include "path_publisher.h"

#include <algorithm>
#include <cmath>

namespace rubble::fusion {

namespace {

constexpr double kSpacing = 0.05;  // m
constexpr std::size_t kNew = 200;
constexpr std::size_t kRepeated = 100;
/// Five kilometres; the oldest go first.
constexpr std::size_t kMostPoints = 100'000;

}  // namespace

void PathPublisher::add(const rubble::robot_pose_t& pose) {
  const auto far = [&](const rubble::trajectory_point_t& last) {
    double squared = 0.0;
    for (int i = 0; i < 3; ++i) {
      const double d = pose.p_world_body[i] - static_cast<double>(last.p_world_body[i]);
      squared += d * d;
    }
    return squared >= kSpacing * kSpacing;
  };
  if (!points_.empty() && !far(points_.back()) && pose.control_state == points_.back().control_state) {
    return;
  }
  rubble::trajectory_point_t point;
  point.utime = pose.utime;
  point.control_state = pose.control_state;
  point.level = pose.level;
  std::transform(pose.p_world_body, pose.p_world_body + 3, point.p_world_body,
                 [](double value) { return static_cast<float>(value); });
  points_.push_back(point);
  if (points_.size() > kMostPoints) {
    points_.pop_front();
    told_ -= std::min<std::size_t>(told_, 1);
  }
}

rubble::trajectory_t PathPublisher::next(std::int64_t utime) {
  rubble::trajectory_t message;
  message.utime = utime;
  message.total = static_cast<std::int32_t>(points_.size());
  const auto tell = [&](std::size_t from, std::size_t to) {
    message.points.insert(message.points.end(), points_.begin() + static_cast<std::ptrdiff_t>(from),
                          points_.begin() + static_cast<std::ptrdiff_t>(to));
  };
  repeated_ = repeated_ < told_ ? repeated_ : 0;
  const std::size_t again = std::min(repeated_ + kRepeated, told_);
  tell(repeated_, again);
  repeated_ = again;
  const std::size_t fresh = std::min(told_ + kNew, points_.size());
  tell(told_, fresh);
  told_ = fresh;
  message.n = static_cast<std::int32_t>(message.points.size());
  return message;
}

}  // namespace rubble::fusion
