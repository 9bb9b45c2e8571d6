#pragma once

#include <vector>

#include "clearance_grid.h"
#include "common/geometry.h"

namespace rubble::arena_sim {

/// How the robot may move; units in visit() (arena_sim_config.cpp).
struct MotionLimits {
  double cruise_speed = 0.8;
  double turn_rate = 1.5;
  double acceleration = 1.0;
  double turn_acceleration = 6.0;
};

/// T_world_body over time, seconds from 0: samples 5 ms apart with straight lines between them, which makes
/// it the exact truth. The yaw runs on over full turns.
class Motion {
 public:
  static constexpr double kStep = 0.005;

  /// Standing at the ends: any time may be asked for.
  common::Pose2 at(double seconds) const;
  double duration() const { return static_cast<double>(samples_.size() - 1) * kStep; }
  const std::vector<common::Pose2>& samples() const { return samples_; }

 private:
  friend class Driver;
  std::vector<common::Pose2> samples_{common::Pose2{}};
};

/// Drives a tracked robot from the world's origin: along ways by pure pursuit (Coulter, CMU-RI-TR-92-01),
/// turning on the spot where a way turns sharply.
class Driver {
 public:
  explicit Driver(const MotionLimits& limits) : limits_(limits) {}

  /// Along the way to a stop at its end; the way begins where the robot is.
  void follow(const Polyline& way);
  /// On the spot, to this heading.
  void turnTo(double yaw);
  void stand(double seconds);

  const Motion& motion() const { return motion_; }

 private:
  const common::Pose2& pose() const { return motion_.samples_.back(); }
  void step(double wanted_speed, double wanted_rate);
  void turnOnTheSpot(const Eigen::Vector2d& target);

  const MotionLimits limits_;
  Motion motion_;
  double speed_ = 0.0;
  double rate_ = 0.0;
};

}  // namespace rubble::arena_sim
