#pragma once

#include <cstdint>
#include <filesystem>

#include "common/config.h"
#include "common/robot_config.h"

namespace rubble::arena_sim {

struct MissionOptions {
  std::uint64_t seed = 1;
  /// Length of the mission, at least kShortestMission; the robot is back at its start by then.
  double duration_s = 75.0;
  bool with_odometry = true;
};

inline constexpr double kShortestMission = 20.0;

/// The arena's robot where the configuration does not say otherwise: that of config/robot.yaml, with a
/// UTM-30LX (270 of 360 degrees in 25 ms).
common::RobotConfig arenaRobot();

/// The mission `flat`: rooms on one level floor, stabiliser at zero. Into the folder `out`, created when
/// missing, go mission.lcm (SCAN, STABILIZER, ODOMETRY, GROUND_TRUTH), robot.yaml (the calibration of this
/// robot), truth/body.tum and truth/lidar.tum (at scan times, in world), truth/map_0.pgm and .yaml, and
/// top_view.png. Sections `robot` and `arena_sim` of the configuration count. The same arguments give the
/// same bytes. Throws common::Error.
void writeFlatMission(const MissionOptions& options, const common::Config& config,
                      const std::filesystem::path& out);

}  // namespace rubble::arena_sim
