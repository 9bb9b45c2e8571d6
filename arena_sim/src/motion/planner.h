#pragma once

#include <optional>
#include <vector>

#include "motion/clearance_grid.h"
#include "motion/driver.h"
#include "motion/route.h"
#include "world/random.h"
#include "world/world.h"

namespace rubble::arena_sim {

/// A piece of the drive that ends with a stop.
struct Leg {
  double pause_s = 0.0;  // Before it.
  Polyline way;
  double speed = 0.0;  // m/s at most
};

/// The robot's plan, leg by leg, driven while it grows. Copies grow on by themselves.
class Planner {
 public:
  Planner(const World& world, const MotionConfig& config, std::uint64_t seed);

  /// To a goal in a room where it has not been for long. Throws common::Error when there is none.
  void addGoal();
  /// Leaves out the room whose turn is next.
  void skipRoom() { nextRoom(); }
  /// To the middle of a ramp field, if there is any.
  void addRampField();
  void addCrossing();
  /// To the start pose.
  void goHome();

  double seconds() const { return driver_.seconds(); }
  /// m, seen from above.
  double length() const;
  /// The same legs at `share` of their speeds.
  std::vector<common::Pose2> driveAgain(double share) const;
  const std::vector<common::Pose2>& poses() const { return driver_.poses(); }

 private:
  void begin();
  void addLeg(const Polyline& way);
  bool driveTo(const Eigen::Vector2d& goal);
  std::optional<Eigen::Vector2d> sampleGoal(const Polygon& room);
  std::size_t nextRoom();
  Driver newDriver() const;

  const World* world_;
  MotionConfig config_;
  std::uint64_t seed_;
  ClearanceGrid grid_;
  Random random_;
  std::vector<std::size_t> rooms_left_;
  std::vector<Leg> legs_;
  Driver driver_;
};

}  // namespace rubble::arena_sim
