#pragma once

#include "common/config.h"
#include "slam_mono/mono_slam_config.h"

namespace rubble::slam_mono {

/// Section `slam_mono`: the algorithm's parameters and those of the process around it.
struct SlamMonoConfig {
  MonoSlamConfig slam;
  double calibration_wait = 1.2;
  bool publish_features = true;
  double map_period = 0.5;
  double checkpoint_period = 1.0;
  double restore_within = 120.0;
  double revisit_after = 0.0;
};

inline void visit(common::ConfigSection& section, SlamMonoConfig& config) {
  visit(section, config.slam);
  section.number("calibration_wait", config.calibration_wait, "s", 0.0, 60.0,
                 "from the first picture, for CAMERA_INFO; then robot.camera is taken");
  section.flag("publish_features", config.publish_features, "publish MONO_FEATURES, which recognition needs");
  section.number("map_period", config.map_period, "s", 0.1, 1.0, "time between MONO_MAP messages");
  section.number("checkpoint_period", config.checkpoint_period, "s", 0.5, 5.0, "time between checkpoints");
  section.number(
      "restore_within", config.restore_within, "s", 0.0, 1e6,
      "age up to which a checkpoint is restored at start; an older one belongs to another mission");
  section.number("revisit_after", config.revisit_after, "s", 0.0, 1e6,
                 "of not finding back into the map until REVISIT_REQUEST asks to return (active loop "
                 "closure); 0: never");
}

}  // namespace rubble::slam_mono
