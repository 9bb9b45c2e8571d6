#pragma once

#include <string>
#include <string_view>

namespace rubble::lidar {

/// What a sensor says of itself with VV, PP and II (SCIP 2.0 section 8).
struct SensorInfo {
  std::string model;
  std::string firmware;
  std::string serial;
  /// II's STAT, e.g. `Sensor works well`.
  std::string state;

  int min_range_mm = 0;    // DMIN; a smaller reading is an error code
  int max_range_mm = 0;    // DMAX
  int steps_per_turn = 0;  // ARES
  int first_step = 0;      // AMIN
  int last_step = 0;       // AMAX
  int front_step = 0;      // AFRT: the step at angle 0, x of frame `lidar`; steps grow counter-clockwise
  int rpm = 0;             // SCAN: turns a minute

  double radStep() const;
  /// rad about lidar z, counter-clockwise from x.
  double angleOf(int step) const { return (step - front_step) * radStep(); }
  /// Seconds for one turn.
  double turnTime() const { return 60.0 / rpm; }
};

/// Takes the fields it knows out of an answer to VV, PP or II (`KEY:value;sum` lines). False when a line is
/// damaged.
bool readFields(std::string_view data, SensorInfo& info);

/// Throws common::Error naming the first parameter of PP that is missing or makes no sense.
void checkParameters(const SensorInfo& info);

}  // namespace rubble::lidar
