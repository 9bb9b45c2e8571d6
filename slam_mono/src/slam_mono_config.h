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
};

inline void visit(common::ConfigSection& section, SlamMonoConfig& config) {
  visit(section, config.slam);
  section.number("calibration_wait", config.calibration_wait, "s", 0.0, 60.0,
                 "from the first picture, for CAMERA_INFO; then robot.camera is taken");
  section.flag("publish_features", config.publish_features, "publish MONO_FEATURES, which recognition needs");
  section.number("map_period", config.map_period, "s", 0.1, 1.0, "time between MONO_MAP messages");
}

}  // namespace rubble::slam_mono
