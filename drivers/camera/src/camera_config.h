#pragma once

#include <string>

#include "common/config.h"
#include "common/robot_config.h"

namespace rubble::camera {

/// Section `camera`: the device. Size and rate of its pictures are the calibration's (`robot.camera`).
struct CameraConfig {
  std::string device = "/dev/video0";
  std::string format = "auto";
  std::string wire = "jpeg";
  int jpeg_quality = 80;
  /// s; 0: the camera finds it.
  double exposure = 0.0;
  /// The device's own units; -1: as it is.
  int gain = -1;
  /// s
  double stamp_delay = 0.0;
  /// s
  double silence = 2.0;
};

/// Throws common::Error for MJPG that would have to be sent as raw grey.
void visit(common::ConfigSection& section, CameraConfig& config);

/// All that the capture has to know.
struct CameraSetup {
  CameraConfig camera;
  common::RobotConfig::Intrinsics lens;
};

}  // namespace rubble::camera
