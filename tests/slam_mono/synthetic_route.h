#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "common/geometry.h"
#include "common/time.h"

namespace rubble::slam_mono {

/// A line on the floor with its corners rounded.
class FloorPath {
 public:
  FloorPath(std::span<const Eigen::Vector2d> line, bool closed, double radius);

  double length() const { return length_; }
  /// The pose `s` metres from the start, heading along; a closed path goes on and on.
  common::Pose2 at(double s) const;

 private:
  struct Piece {
    common::Pose2 start;
    double length = 0.0;
    double curvature = 0.0;  // 1 / m, positive to the left
  };
  std::vector<Piece> pieces_;
  double length_ = 0.0;
  bool closed_ = false;
};

struct StampedPose {
  common::Utime utime = 0;
  common::Pose3 T_world_camera = common::Pose3::Identity();
};

/// What a small robot's forward-looking camera goes through, picture by picture: 0.25 m over the floor, with
/// a little vibration.
class Route {
 public:
  /// `rate` in Hz; the vibration follows from the seed.
  Route(const common::Pose2& T_world_body, double rate, std::uint64_t seed);

  /// Along the path from s metres on; the robot must be there, or is carried there.
  void drive(const FloorPath& path, double s, double metres, double speed = 0.5);
  void stand(double seconds);
  /// Turns on the spot at constant speed.
  void turn(double angle, double seconds);
  /// The camera sits this far (m) in front of the axis of a turn; 0 at first.
  void setCameraAhead(double ahead) { camera_ahead_ = ahead; }
  /// Shakes only while true, from the start on.
  void setVibration(bool on) { vibrates_ = on; }

  const std::vector<StampedPose>& poses() const { return poses_; }
  common::Pose2 T_world_body() const { return T_world_body_; }

 private:
  void add(const common::Pose2& T_world_body);

  double rate_;
  double phase_;
  double camera_ahead_ = 0.0;
  bool vibrates_ = true;
  common::Pose2 T_world_body_;
  std::vector<StampedPose> poses_;
};

}  // namespace rubble::slam_mono
