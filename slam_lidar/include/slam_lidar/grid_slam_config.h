#pragma once

#include "common/config.h"

namespace rubble::slam_lidar {

/// Parameters of GridSlam. Units and meaning of every field are in visit() (grid_slam_config.cpp);
/// `rubble` prints them as commented YAML.
struct GridSlamConfig {
  struct Map {
    double cell_size = 0.05;
    int levels = 3;
    double hit_probability = 0.75;
    double miss_probability = 0.45;
    double max_log_odds = 6.0;
    double write_distance = 0.25;
    double write_angle = 0.1;
    double max_tilt = 0.035;
  } map;

  struct Scan {
    double min_range = 0.1;
    double max_range = 80.0;
    double free_space_range = 15.0;
    double height_below_ceiling = 10.0;
    double height_margin = 0.1;
    double slice = 0.08;
    int min_beams = 20;
    // Not in visit(): the robot's, from section `robot`.
    double sweep_duration = 0.0;      // s, first beam to one step after the last
    double height_above_floor = 0.5;  // m, of the LiDAR's origin
  } scan;

  struct Match {
    int max_iterations = 12;
    double max_speed = 2.0;
    double lost_score = 0.2;
    double good_score = 0.7;
    int verify_scans = 3;
  } match;

  struct Search {
    double local_distance = 0.5;
    double local_angle = 0.6;
    double wide_distance = 3.0;
    double wide_angle = 3.2;
    int wide_period = 4;
    int give_up_scans = 12;
  } search;
};

/// Names every field once: reads, validates and documents it.
void visit(common::ConfigSection& section, GridSlamConfig& config);

}  // namespace rubble::slam_lidar
