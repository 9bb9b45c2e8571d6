#include "lidar_config.h"

#include <fmt/format.h>

#include "common/error.h"
#include "device/address.h"
#include "device/connection.h"

namespace rubble::lidar {

void visit(common::ConfigSection& section, LidarConfig& config) {
  section.text("connection", config.connection, "tcp://HOST:PORT or serial:///dev/NAME");
  section.integer("baud", config.baud, "bit/s", 19'200, 500'000,
                  "of an RS-232 line; USB and TCP take no notice");
  section.number("first_angle", config.first_angle, "rad", -3.2, 3.2,
                 "of the field of view, about lidar z from x; what the sensor does not see is left out");
  section.number("last_angle", config.last_angle, "rad", -3.2, 3.2, "of the field of view");
  section.integer("cluster", config.cluster, "", 1, 99, "steps that become one beam, the nearest of them");
  section.integer("skip", config.skip, "", 0, 9, "scans left out after each one");
  section.flag("intensities", config.intensities, "ask for intensities too (ME instead of MD)");
  section.number("silence_timeout", config.silence_timeout, "s", 0.1, 60,
                 "without an answer or scan after which the sensor counts as hung");
  section.number("first_pause", config.first_pause, "s", 0.01, 60,
                 "before the first try to connect again; doubles from try to try");
  section.number("longest_pause", config.longest_pause, "s", 0.01, 600, "between two tries to connect");
  parseAddress(config.connection);
  if (!isBaudRate(config.baud)) {
    throw common::Error(fmt::format(
        "lidar.baud = {}: use 19200, 38400, 57600, 115200, 230400, 460800 or 500000", config.baud));
  }
  if (config.first_angle >= config.last_angle) {
    throw common::Error(fmt::format("lidar.first_angle = {} is not below lidar.last_angle = {}",
                                    config.first_angle, config.last_angle));
  }
  if (config.first_pause > config.longest_pause) {
    throw common::Error(fmt::format("lidar.first_pause = {} is above lidar.longest_pause = {}",
                                    config.first_pause, config.longest_pause));
  }
}

}  // namespace rubble::lidar
