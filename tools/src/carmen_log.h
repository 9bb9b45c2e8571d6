#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/geometry.h"
#include "common/time.h"
#include "text_lines.h"

namespace rubble::tools {

/// One sweep of the front laser.
struct CarmenScan {
  common::Utime utime = 0;
  std::vector<float> ranges;      // m; infinite: no return
  std::vector<float> remissions;  // empty or one per range, sensor units
  float rad0 = 0.0F;              // rad, first beam, counter-clockwise from ahead
  float radstep = 0.0F;           // rad
  double max_range = 0.0;         // m as the line states it; 0: it states none
  std::optional<common::Pose2> T_odom_body;
};

struct CarmenPose {
  common::Utime utime = 0;
  common::Pose2 T_a_body;
};

/// What a CARMEN log file (CARMEN Robot Navigation Toolkit, "one message per line") tells about the front
/// laser, the wheels and the true pose. Every stamp is the line's IPC timestamp.
struct CarmenLog {
  std::vector<CarmenScan> scans;       // in the file's order
  std::vector<CarmenPose> odometry;    // T_odom_body
  std::vector<CarmenPose> truth;       // T_world_body
  std::optional<double> laser_offset;  // m, of the front laser ahead of the body's origin
  /// Ranges of exactly this value mean no return although nothing in the log says so: the sensor's limit.
  std::optional<float> clipped_range;
  std::map<std::string, int> skipped;  // messages of other kinds
};

/// Scans come from ROBOTLASER1 lines, without any from FLASER, without those from RAWLASER1 (a log repeats
/// a scan in several kinds). Odometry comes from ODOM lines, without any from the scans' own fields, unless
/// these are all zero. Ranges at or above the sensor's maximum become infinite. Throws Error naming file
/// and line for a line that is no CARMEN message.
CarmenLog parseCarmen(const TextFile& file);

/// Angle of the first beam and step of a FLASER line of n >= 2 beams, by CARMEN's convention: -90 degrees,
/// and 180 / n degrees for an even n, 180 / (n - 1) for an odd one.
inline constexpr double kFlaserRad0 = -1.5707963267948966;
double flaserStep(std::size_t n);

/// What a SICK in CARMEN logs reports for no return, m; no range at or above kCarmenNoReturn is a hit.
inline constexpr double kSickMaxRange = 81.91;
inline constexpr double kCarmenNoReturn = 80.0;

}  // namespace rubble::tools
