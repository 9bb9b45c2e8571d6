#pragma once

#include <string>
#include <string_view>

#include "protocol/sensor_info.h"

namespace rubble::lidar {

/// What MD (ranges) or ME (ranges and intensities) asks for: scans without end (SCIP 2.0 section 8.1).
struct ScanRequest {
  int first_step = 0;
  int last_step = 0;
  /// Steps that become one beam, the nearest of them.
  int cluster = 1;
  /// Scans left out between two.
  int skip = 0;
  bool intensities = false;

  int beams() const { return (last_step - first_step + 1) / cluster; }
  /// Of the encoded beams of one scan.
  int dataCharacters() const { return beams() * (intensities ? 6 : 3); }
};

/// The part of a sensor's field of view that is wanted, and how.
struct ScanWish {
  // rad about lidar z, counter-clockwise from x; what the sensor does not see is left out.
  double first_angle = 0.0;
  double last_angle = 0.0;
  // As in ScanRequest.
  int cluster = 1;
  int skip = 0;
  bool intensities = false;
};

/// The wish in steps, whole clusters only. Throws common::Error naming the angles when nothing is left.
ScanRequest requestFor(const SensorInfo& sensor, const ScanWish& wish);

/// The command without its line feed. Scans carry the same text as their echo, but for the last two digits.
std::string commandOf(const ScanRequest& request);

/// Without the digits that change.
inline std::string_view withoutCount(std::string_view scan_echo) {
  return scan_echo.substr(0, scan_echo.size() < 2 ? 0 : scan_echo.size() - 2);
}

}  // namespace rubble::lidar
