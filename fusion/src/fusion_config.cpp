#include "fusion_config.h"

namespace rubble::fusion {

void visit(common::ConfigSection& section, FusionConfig& config) {
  section.choice(
      "mode", config.plane.mode, {"lsm", "lsm-robust", "joint"},
      "lsm: scale by axes and switching on height alone (Chen et al. 2017, eq. 8, 10); lsm-robust: one "
      "alignment, switching on height, tilt and scans with hysteresis; joint: the same switching, the pose "
      "by a sliding window over both sensors");
  auto& plane = section.section("plane", "when the LiDAR's plane is usable (H)");
  plane.number("height_band", config.plane.height_band, "m", 0.01, 10.0,
               "to either side of the LiDAR's height over the level's floor");
  plane.number("largest_tilt", config.plane.largest_tilt, "rad", 0.001, 1.5, "of the LiDAR's plane");
  plane.number("leave_after", config.plane.leave_after, "s", 0.0, 5.0, "beyond the limits until M");
  plane.number("return_band", config.plane.return_band, "", 0.1, 1.0, "share of both limits for the return");
  plane.number("return_after", config.plane.return_after, "s", 0.0, 5.0, "within it until R");
  plane.integer("verify_scans", config.plane.verify_scans, "", 1, 1000,
                "that agree with the map and with vision in a row until H");
  plane.integer("observe_scans", config.plane.observe_scans, "", 1, 10000,
                "the same where the attitude was unknown: a tilted plane would not agree for long");
  plane.integer("contradictions", config.plane.contradictions, "", 1, 10000,
                "scans in a row that contradict vision until M: the LiDAR slides, as at the foot of a ramp");
  plane.flag("levels", config.plane.levels, "another level floor gets a grid of its own; off: M there");
  plane.number("floor_after", config.plane.floor_after, "s", 0.2, 60.0,
               "of standing level at one height, after a slope, until that is a level");

  auto& alignment = section.section("alignment", "of the monocular map with world, standard deviations");
  alignment.number("position_sigma", config.alignment.position_sigma, "m", 1e-4, 10.0,
                   "LiDAR's positions against vision's");
  alignment.number("heading_sigma", config.alignment.heading_sigma, "rad", 1e-4, 1.0, "headings");
  alignment.number("floor_sigma", config.alignment.floor_sigma, "m", 1e-3, 10.0,
                   "height of the body over the level's floor in H; larger ones count little");
  alignment.number("level_sigma", config.alignment.level_sigma, "rad", 1e-3, 10.0,
                   "tilt of the body on the level's floor in H; larger ones count little");
  alignment.number("tilt_sigma", config.alignment.tilt_sigma, "rad", 1e-4, 1.0,
                   "by which the map's tilt may differ from the last estimate");
  alignment.number("scale_sigma", config.alignment.scale_sigma, "", 1e-4, 1.0,
                   "share by which the scale may differ from the last estimate");
  section.number("window", config.window, "m", 0.5, 1000.0, "way in H that the alignment looks back");
  section.number("min_way", config.min_way, "m", 0.05, 10.0, "of the LiDAR before the first scale");
  section.number("max_scale_sigma", config.max_scale_sigma, "", 0.001, 1.0,
                 "relative deviation of the scale above which it is unknown");
  section.number("firm_way", config.firm_way, "m", 0.0, 100.0,
                 "that a scale was learnt on until vision, not the LiDAR, carries the pose in H");
  section.number("lidar_gain", config.lidar_gain, "", 0.01, 1.0,
                 "share of a scan's correction in position and heading");
  section.number("alignment_gain", config.alignment_gain, "", 0.01, 1.0,
                 "share of an alignment's correction in height and tilt");
  section.number("servo_range", config.servo_range, "rad", 0.0, 1.5, "of both plate angles to either side");
  section.number("servo_lead", config.servo_lead, "s", 0.0, 0.5,
                 "by which the plate lags behind its set-points: they are predicted by it");
  section.number("checkpoint_period", config.checkpoint_period, "s", 0.5, 5.0, "time between checkpoints");
  section.number(
      "restore_within", config.restore_within, "s", 0.0, 1e6,
      "age up to which a checkpoint is restored at start; an older one belongs to another mission");
  visit(section.section("joint", "the sliding window of mode joint"), config.joint);
  visit(section.section("marks", "objects in the map"), config.marks);
}

}  // namespace rubble::fusion
