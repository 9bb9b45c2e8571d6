#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "arena_sim/mission.h"
#include "arena_sim/samples.h"
#include "closed_loop.h"
#include "command.h"
#include "common/error.h"
#include "progress.h"

namespace rubble::tools {

namespace {

struct ArenaOptions {
  arena_sim::MissionOptions mission;
  double duration_s = 0.0;
  std::string out;
  std::string samples;
  bool without_camera = false;
  bool without_odometry = false;
  bool without_cache = false;
  bool closed_loop = false;
  std::vector<std::string> config_files;
  std::vector<std::string> overrides;
};

void runArena(const ArenaOptions& options) {
  if (!options.samples.empty()) {
    arena_sim::writeSamples(options.samples);
    return;
  }
  common::Config config;
  for (const std::string& file : options.config_files) {
    config.addFile(file);
  }
  for (const std::string& assignment : options.overrides) {
    config.addOverride(assignment);
  }
  arena_sim::MissionOptions mission = options.mission;
  if (options.duration_s > 0.0) {
    mission.duration_s = options.duration_s;
  }
  mission.with_camera = !options.without_camera;
  mission.with_odometry = !options.without_odometry;
  if (!options.without_cache) {
    mission.cache = arena_sim::userCache();
  }
  std::optional<ClosedLoop> loop;
  if (options.closed_loop) {
    mission.make_robot = [&](const std::filesystem::path& robot_yaml) {
      common::Config with_calibration = config;
      with_calibration.addFile(robot_yaml);
      loop.emplace(with_calibration);
      return [&](const lcm_io::RawMessage& message) { return loop->handle(message); };
    };
  }
  constexpr std::int64_t kSteps = 1000;
  Progress progress("arena", kSteps);
  mission.progress = [&](double share) { progress.update(static_cast<std::int64_t>(share * kSteps)); };
  arena_sim::writeMission(mission, config, options.out);
  if (loop) {
    loop->write(std::filesystem::path(options.out) / "results");
  }
}

}  // namespace

void addArenaCommand(CLI::App& app) {
  const auto options = std::make_shared<ArenaOptions>();
  CLI::App* command = app.add_subcommand("arena", "Simulate a mission with exact truth from a seed");
  command
      ->add_option(
          "--mission", options->mission.kind,
          "What the robot does: flat (rooms on one level floor), rescue (floor, steep ramp, platform, stairs "
          "and back), tour (random goals, now and then over the platform)")
      ->check(CLI::IsMember({"flat", "rescue", "tour"}))
      ->capture_default_str();
  command->add_option("--seed", options->mission.seed, "Same seed, same bytes")->capture_default_str();
  command
      ->add_option(
          "--duration", options->duration_s,
          "Longest drive, s; the robot uses what it needs (default: about 75 flat, 180 rescue, 300 tour)")
      ->check(CLI::Range(arena_sim::kShortestMission, 3600.0));
  command->add_flag("--without-camera", options->without_camera, "Leave CAMERA out: nothing is rendered");
  command->add_flag("--without-odometry", options->without_odometry, "Leave ODOMETRY out of the log");
  command->add_flag("--no-cache", options->without_cache,
                    "Neither take the mission from ~/.cache/rubble/arena nor keep it there");
  command->add_flag(
      "--closed-loop", options->closed_loop,
      "Arena and processes in lockstep: the fused attitude levels the plate; what the processes make of "
      "the mission goes to results/; never cached");
  command
      ->add_option("--config", options->config_files,
                   "YAML with sections robot, arena_sim (closed loop: fusion ... too); later files win")
      ->allow_extra_args(false);
  command->add_option("--set", options->overrides, "One value, e.g. --set arena_sim.lidar.range_sigma=0.03")
      ->allow_extra_args(false);
  CLI::Option_group* result = command->add_option_group("Result", "One of");
  result->add_option("--out", options->out,
                     "Folder for mission.lcm, robot.yaml, truth/, preview.png and top_view.png");
  result->add_option(
      "--samples", options->samples,
      "No mission: folder for sample pictures of hazard labels and victims, for `rubble train`");
  result->require_option(1);
  command->footer(
      "Examples:\n  rubble arena --mission rescue --seed 7 --out mission\n  rubble arena --samples "
      "samples\n");
  command->callback([options] { runArena(*options); });
}

}  // namespace rubble::tools
