#pragma once

#include <string>

#include "common/config.h"

namespace rubble::lidar {

/// Section `lidar`.
struct LidarConfig {
  std::string connection = "tcp://192.168.0.10:10940";
  int baud = 115'200;
  double first_angle = -3.2;
  double last_angle = 3.2;
  int cluster = 1;
  int skip = 0;
  bool intensities = false;
  double silence_timeout = 1.0;
  double first_pause = 0.2;
  double longest_pause = 5.0;
};

/// Throws common::Error for an address that is none, an unknown bit rate and limits in the wrong order.
void visit(common::ConfigSection& section, LidarConfig& config);

}  // namespace rubble::lidar
