#pragma once

#include "common/config.h"
#include "slam_lidar/grid_slam_config.h"

namespace rubble::slam_lidar {

/// Section `slam_lidar`: the algorithm's parameters and those of the process around it.
struct SlamLidarConfig {
  GridSlamConfig grid;
  bool use_odometry = true;
  double attitude_wait = 0.06;
  double control_timeout = 0.5;
  double map_period = 1.0;
  double checkpoint_period = 2.0;
  double restore_within = 120.0;
};

inline void visit(common::ConfigSection& section, SlamLidarConfig& config) {
  visit(section, config.grid);
  section.flag("use_odometry", config.use_odometry, "seed the match with ODOMETRY where it is published");
  section.number("attitude_wait", config.attitude_wait, "s", 0.0, 1.0,
                 "how long a scan waits for its attitude and odometry before they are extrapolated");
  section.number("control_timeout", config.control_timeout, "s", 0.1, 10.0,
                 "silence of LIDAR_CONTROL after which nothing is written (once it was heard)");
  section.number("map_period", config.map_period, "s", 0.1, 1.0, "time between GRID_MAP messages");
  section.number("checkpoint_period", config.checkpoint_period, "s", 0.5, 5.0, "time between checkpoints");
  section.number(
      "restore_within", config.restore_within, "s", 0.0, 1e6,
      "age up to which a checkpoint is restored at start; an older one belongs to another mission");
}

}  // namespace rubble::slam_lidar
