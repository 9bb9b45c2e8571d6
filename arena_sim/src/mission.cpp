#include "arena_sim/mission.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "common/error.h"
#include "common/files.h"
#include "config.h"
#include "contact_sheet.h"
#include "folders.h"
#include "lcm_io/log_file.h"
#include "mission_cache.h"
#include "mission_world.h"
#include "sensors/plate_controller.h"
#include "simulation.h"
#include "truth/top_view.h"

namespace rubble::arena_sim {

namespace {

namespace fs = std::filesystem;

/// Grows when the same scenario comes to look or sound different. Older cached missions are then stale.
constexpr int kOutputVersion = 3;

constexpr std::uint32_t kControllerStream = 20;

MissionKind kindOf(const std::string& name) {
  if (name == "flat") {
    return MissionKind::kFlat;
  }
  if (name == "rescue") {
    return MissionKind::kRescue;
  }
  if (name == "tour") {
    return MissionKind::kTour;
  }
  throw common::Error(fmt::format("there is no mission `{}`; choose flat, rescue or tour", name));
}

/// The same view in pictures of another size.
void scalePictures(common::RobotConfig::Intrinsics& lens, double scale) {
  lens.width = std::max(1, static_cast<int>(std::lround(lens.width * scale)));
  lens.height = std::max(1, static_cast<int>(std::lround(lens.height * scale)));
  for (std::size_t i = 0; i < 2; ++i) {
    lens.focal[i] *= scale;
    lens.centre[i] = (lens.centre[i] + 0.5) * scale - 0.5;
  }
}

void record(const MissionOptions& options, MissionKind kind, const ArenaSimConfig& config,
            const common::RobotConfig& calibration, const fs::path& out) {
  const World world = makeMissionWorld(kind, config.world, options.seed);
  const Motion motion = planMission(world, kind, options.seed, options.duration_s, config.motion);

  lcm_io::LogWriter log(out / "mission.lcm");
  ContactSheet sheet(motion.duration());
  const Robot robot = options.make_robot ? options.make_robot(out / kCalibrationFile) : nullptr;
  RobotWish wish;
  Simulation simulation(
      world, motion, config, calibration, options.seed, {options.with_camera, options.with_odometry},
      [&](common::Utime received, const char* channel, const lcm_io::Bytes& data) {
        log.write(received, channel, data);
        if (robot) {
          RobotWish answer = robot({channel, received, data});
          if (answer.plate) {
            wish.plate = answer.plate;
          }
          if (answer.revisit) {
            wish.revisit = std::move(answer.revisit);
          }
        }
      },
      [&](double seconds, const cv::Mat& bgr) { sheet.add(seconds, bgr); });
  PlateController controller(
      config.plate_controller, [&](double t) { return simulation.motion().at(t); },
      randomStream(options.seed, kControllerStream));
  const double period = 1.0 / config.plate_controller.rate;
  for (double next_command = 0.0; simulation.step();) {
    if (const auto request = std::exchange(wish.revisit, std::nullopt)) {
      simulation.revisit(*request);
    }
    if (const auto command = std::exchange(wish.plate, std::nullopt)) {
      simulation.commandPlate(*command);
    } else if (!robot && simulation.seconds() >= next_command) {
      simulation.commandPlate(controller.next(simulation.seconds()));
      next_command += period;
    }
    if (options.progress) {
      options.progress(simulation.seconds() / motion.duration());
    }
  }
  log.close();
  simulation.truth().write(out / "truth");
  writeTopView(out / "top_view.png", world, simulation.truth().map(), simulation.motion());
  if (options.with_camera) {
    sheet.write(out / "preview.png");
  }
}

}  // namespace

common::RobotConfig arenaRobot() {
  common::RobotConfig robot;
  robot.plate_translation = {0.10, 0.0, 0.25};
  robot.lidar_sweep_time_s = 0.01875;
  robot.intrinsics.distortion = {-0.22, 0.045, 0.0006, -0.0004};
  return robot;
}

fs::path userCache() {
  if (const char* cache = std::getenv("XDG_CACHE_HOME"); cache != nullptr && *cache != '\0') {
    return fs::path(cache) / "rubble" / "arena";
  }
  const char* home = std::getenv("HOME");
  return home != nullptr && *home != '\0' ? fs::path(home) / ".cache" / "rubble" / "arena" : "";
}

void writeMission(const MissionOptions& options, const common::Config& config, const fs::path& out) {
  const MissionKind kind = kindOf(options.kind);
  if (options.duration_s && !(*options.duration_s >= kShortestMission)) {
    throw common::Error(fmt::format("a mission of {} s is too short; give it at least {} s",
                                    *options.duration_s, kShortestMission));
  }
  auto robot = config.read<common::RobotConfig>("robot", arenaRobot());
  const auto scenario = config.read<ArenaSimConfig>("arena_sim");
  scalePictures(robot.intrinsics, scenario.picture_scale);
  const std::string robot_yaml = common::Config().describe<common::RobotConfig>("robot", robot);
  const std::string scenario_yaml = config.describe<ArenaSimConfig>("arena_sim");
  createFolder(out);
  for (const char* name : {"mission.lcm", "preview.png", "top_view.png", "truth"}) {
    fs::remove_all(out / name);  // Of an earlier mission.
  }

  const bool keeps = !options.cache.empty() && !options.make_robot;
  const MissionCache cache(
      options.cache, fmt::format("{} {} {} {} {} {}\n{}{}", kOutputVersion, options.kind, options.seed,
                                 options.duration_s.value_or(0.0), options.with_camera, options.with_odometry,
                                 robot_yaml, scenario_yaml));
  if (keeps && cache.fetch(out)) {
    return;
  }
  common::writeFileAtomically(out / kCalibrationFile, robot_yaml);
  common::writeFileAtomically(out / kScenarioFile, scenario_yaml);
  record(options, kind, scenario, robot, out);
  if (keeps) {
    cache.store(out);
  }
}

}  // namespace rubble::arena_sim
