#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <rubble/robot_pose_t.hpp>
#include <rubble/trajectory_t.hpp>

namespace rubble::fusion {

/// Thins the robot's poses to its way and tells it in messages of bounded size.
class PathPublisher {
 public:
  /// Keeps the pose when the robot has moved on since the last one kept.
  void add(const rubble::robot_pose_t& pose);
  /// New points, and older ones in turn.
  rubble::trajectory_t next(std::int64_t utime);

 private:
  std::deque<rubble::trajectory_point_t> points_;
  std::size_t told_ = 0;      // Points that were told at least once.
  std::size_t repeated_ = 0;  // The next one to be told again.
};

}  // namespace rubble::fusion
