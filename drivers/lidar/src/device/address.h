#pragma once

#include <string>

namespace rubble::lidar {

/// Where the sensor is: `tcp://HOST:PORT` or `serial:///dev/NAME` (RS-232, USB).
struct Address {
  std::string text;  // As it was written.
  bool is_serial = false;
  std::string path;  // Of the serial port.
  std::string host;
  std::string port;
};

/// Throws common::Error saying what an address looks like.
Address parseAddress(const std::string& text);

}  // namespace rubble::lidar
