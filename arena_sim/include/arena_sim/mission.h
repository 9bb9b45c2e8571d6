#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <rubble/revisit_request_t.hpp>
#include <rubble/stabilizer_command_t.hpp>
#include <string>

#include "common/config.h"
#include "common/robot_config.h"
#include "lcm_io/bus.h"

namespace rubble::arena_sim {

/// What the robot's processes want, if anything.
struct RobotWish {
  std::optional<rubble::stabilizer_command_t> plate;
  std::optional<rubble::revisit_request_t> revisit;
};

/// The robot's processes in lockstep with the arena: given every message in the order of arrival, answers
/// with what they wanted last since the message before.
using Robot = std::function<RobotWish(const lcm_io::RawMessage&)>;

struct MissionOptions {
  /// "flat", "rescue" or "tour".
  std::string kind = "flat";
  std::uint64_t seed = 1;
  /// Longest drive; the robot is back at its start by then. Empty: as long as this kind usually takes.
  std::optional<double> duration_s;
  bool with_camera = true;
  bool with_odometry = true;
  /// Where finished missions are kept, to be copied when they are asked for again; empty: nowhere.
  std::filesystem::path cache;
  /// Closes the loop: the robot, made from its calibration (section `robot` of a YAML file), moves the plate.
  /// Such a mission depends on more than its scenario and is never kept.
  std::function<Robot(const std::filesystem::path& robot_yaml)> make_robot;
  /// Told the share done, 0 .. 1.
  std::function<void(double)> progress;
};

inline constexpr double kShortestMission = 20.0;

/// The arena's robot where the configuration does not say otherwise: that of config/robot.yaml, with a
/// UTM-30LX (270 of 360 degrees in 25 ms) and a wide-angle camera.
common::RobotConfig arenaRobot();

/// Where a user's missions are kept, as the XDG base directory specification has it: ~/.cache/rubble/arena.
/// Empty when there is no home.
std::filesystem::path userCache();

/// A mission; without a robot the plate under the LiDAR follows a controller on late, noisy truth. Into the
/// folder `out`, created when missing, go mission.lcm (the sources and GROUND_TRUTH), robot.yaml (the
/// calibration of this robot), arena_sim.yaml (the scenario), truth/ (body.tum, camera.tum, lidar.tum,
/// states.csv, map_0.yaml .., objects.csv), preview.png and top_view.png. Sections `robot` and `arena_sim` of
/// the configuration count. The same arguments give the same bytes. Throws common::Error.
void writeMission(const MissionOptions& options, const common::Config& config,
                  const std::filesystem::path& out);

}  // namespace rubble::arena_sim
