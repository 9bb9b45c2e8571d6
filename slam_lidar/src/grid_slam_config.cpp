#include "slam_lidar/grid_slam_config.h"

namespace rubble::slam_lidar {

void visit(common::ConfigSection& section, GridSlamConfig& config) {
  auto& map = section.section("map", "occupancy grid");
  map.number("cell_size", config.map.cell_size, "m", 0.01, 1.0, "side of a cell of the finest level");
  map.integer("levels", config.map.levels, "", 1, 6, "resolutions, each half as fine as the one before");
  map.number("hit_probability", config.map.hit_probability, "", 0.5, 0.99, "occupancy a hit argues for");
  map.number("miss_probability", config.map.miss_probability, "", 0.01, 0.5,
             "occupancy a beam passing argues for");
  map.number("max_log_odds", config.map.max_log_odds, "", 1.0, 100.0, "certainty at which a cell stays");
  map.number("write_distance", config.map.write_distance, "m", 0.0, 10.0,
             "way after which a scan is written");
  map.number("write_angle", config.map.write_angle, "rad", 0.0, 3.2, "turn after which a scan is written");
  map.number("max_tilt", config.map.max_tilt, "rad", 0.0, 1.6,
             "of the LiDAR's plane; a scan that is tilted more is matched but not written");

  auto& scan = section.section("scan", "the LiDAR and which of its beams count");
  scan.number("min_range", config.scan.min_range, "m", 0.0, 10.0, "nearer beams are ignored");
  scan.number("max_range", config.scan.max_range, "m", 1.0, 200.0, "beams this long or longer are ignored");
  scan.number("free_space_range", config.scan.free_space_range, "m", 0.0, 200.0,
              "how far along a beam cells are marked as free");
  scan.number("height_below_ceiling", config.scan.height_below_ceiling, "m", 0.01, 100.0,
              "of the LiDAR's origin");
  scan.number("height_margin", config.scan.height_margin, "m", 0.0, 1.0,
              "beams ending this close to floor or ceiling are dropped");
  scan.number("slice", config.scan.slice, "m", 0.0, 10.0,
              "beams ending farther above or below the LiDAR's height on the level's floor are matched, not "
              "written: a "
              "map is one slice");
  scan.integer("min_beams", config.scan.min_beams, "", 3, 10000,
               "a scan with fewer usable beams is not matched");

  auto& match = section.section("match", "scan to map alignment");
  match.integer("max_iterations", config.match.max_iterations, "", 1, 100,
                "Gauss-Newton steps on each level");
  match.number("max_speed", config.match.max_speed, "m/s", 0.1, 50.0,
               "of the robot: bounds the predicted motion");
  match.number("lost_score", config.match.lost_score, "", 0.0, 1.0, "a match that scores less is no match");
  match.number("good_score", config.match.good_score, "", 0.0, 1.0,
               "after a loss, a match has to score this to be trusted again");
  match.integer("verify_scans", config.match.verify_scans, "", 1, 100,
                "good matches in a row, after a loss, before scans are written again");

  auto& search = section.section("search", "correlative search, where Gauss-Newton cannot be trusted");
  search.number("local_distance", config.search.local_distance, "m", 0.1, 10.0, "around the prediction");
  search.number("local_angle", config.search.local_angle, "rad", 0.05, 3.2, "around the prediction");
  search.number("wide_distance", config.search.wide_distance, "m", 0.5, 50.0,
                "around the last pose, when lost");
  search.number("wide_angle", config.search.wide_angle, "rad", 0.1, 3.2, "around the last pose, when lost");
  search.integer("wide_period", config.search.wide_period, "", 1, 1000,
                 "scans from one wide search to the next");
  search.integer("give_up_scans", config.search.give_up_scans, "", 1, 1000000,
                 "lost scans in a row after which mapping goes on from the predicted pose");
}

}  // namespace rubble::slam_lidar
