#pragma once

#include <vector>

#include "common/geometry.h"
#include "motion/clearance_grid.h"
#include "motion/route.h"
#include "world/random.h"
#include "world/world.h"

namespace rubble::arena_sim {

/// Ground where the robot goes slower and slips more.
struct SlowZone {
  SlowZone(const Polygon& zone, double zone_speed, double zone_slope, double zone_slip);

  /// As depthInside(area, p) where that is above -1 m; cheap elsewhere.
  double depth(const Eigen::Vector2d& p) const;

  Polygon area;
  double speed = 0.0;  // m/s along the slope
  double slope = 0.0;  // rad
  double slip = 1.0;   // Times that of level ground.

 private:
  Eigen::Vector2d centre_ = Eigen::Vector2d::Zero();
  double radius_ = 0.0;
};

std::vector<SlowZone> slowZonesOf(const World& world);

/// Drives a tracked robot from the world's origin in the plane: along ways by pure pursuit (Coulter,
/// CMU-RI-TR-92-01), turning on the spot where a way turns sharply. The tracks slip, and the driver steers by
/// where the robot really is. Copies drive on by themselves.
class Driver {
 public:
  Driver(const MotionConfig& config, std::vector<SlowZone> zones, std::uint64_t seed);

  /// Along the way to a stop at its end; the way begins where the robot is.
  void follow(const Polyline& way, double cruise_speed);
  /// On the spot, to this heading.
  void turnTo(double yaw);
  void stand(double seconds);

  const common::Pose2& pose() const { return poses_.back(); }
  /// Motion::kStep apart.
  const std::vector<common::Pose2>& poses() const { return poses_; }
  double seconds() const;

 private:
  void step(double wanted_speed, double wanted_rate);
  void turnOnTheSpot(const Eigen::Vector2d& target);
  double speedLimit(double cruise_speed) const;

  MotionConfig config_;
  std::vector<SlowZone> zones_;
  Random random_;
  std::vector<common::Pose2> poses_{common::Pose2{}};
  double speed_ = 0.0;
  double rate_ = 0.0;
  double slope_ = 0.0;
  double slip_forward_ = 0.0;
  double slip_turn_ = 0.0;
};

}  // namespace rubble::arena_sim
