#include "arena_sim_config.h"

namespace rubble::arena_sim {

void visit(common::ConfigSection& section, ArenaSimConfig& config) {
  common::ConfigSection& lidar =
      section.section("lidar", "planar LiDAR; mount and sweep time are in `robot`");
  lidar.integer("beams", config.lidar.beams, "", 2, 10'000, "beams of a scan");
  lidar.number("field_of_view", config.lidar.field_of_view, "rad", 0.1, 6.2832,
               "first to last beam, about x");
  lidar.number("rate", config.lidar.rate, "Hz", 1.0, 100.0, "scans per second");
  lidar.number("range_sigma", config.lidar.range_sigma, "m", 0.0, 0.5, "noise of a range, 1 sigma");
  lidar.number("dropout_rate", config.lidar.dropout_rate, "", 0.0, 1.0, "share of beams without return");
  lidar.number("min_range", config.lidar.min_range, "m", 0.0, 10.0, "nothing is returned below");
  lidar.number("max_range", config.lidar.max_range, "m", 1.0, 100.0, "nothing is returned beyond");

  common::ConfigSection& odometry = section.section("odometry", "tracks that slip");
  odometry.number("rate", config.odometry.rate, "Hz", 1.0, 200.0, "messages per second");
  odometry.number("slip_forward", config.odometry.slip_forward, "", 0.0, 0.5,
                  "relative error of distances, 1 sigma");
  odometry.number("slip_turn", config.odometry.slip_turn, "", 0.0, 0.5, "relative error of turns, 1 sigma");
  odometry.number("slip_memory", config.odometry.slip_memory, "s", 0.01, 100.0,
                  "time over which slip changes");
  odometry.number("heading_drift", config.odometry.heading_drift, "rad/sqrt(m)", 0.0, 0.5,
                  "heading error after one metre, 1 sigma; grows with the root of the way");

  common::ConfigSection& motion = section.section("motion", "how the robot drives");
  motion.number("cruise_speed", config.motion.cruise_speed, "m/s", 0.1, 2.0, "fastest on a straight line");
  motion.number("turn_rate", config.motion.turn_rate, "rad/s", 0.2, 3.0, "fastest turn");
  motion.number("acceleration", config.motion.acceleration, "m/s^2", 0.1, 5.0, "speeding up and braking");
  motion.number("turn_acceleration", config.motion.turn_acceleration, "rad/s^2", 0.5, 30.0,
                "beginning and ending turns");
}

}  // namespace rubble::arena_sim
