#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <vector>

#include "arena_sim/mission.h"
#include "command.h"

namespace rubble::tools {

namespace {

struct ArenaOptions {
  arena_sim::MissionOptions mission;
  std::string name = "flat";
  std::string out;
  bool without_odometry = false;
  std::vector<std::string> config_files;
  std::vector<std::string> overrides;
};

void runArena(const ArenaOptions& options) {
  common::Config config;
  for (const std::string& file : options.config_files) {
    config.addFile(file);
  }
  for (const std::string& assignment : options.overrides) {
    config.addOverride(assignment);
  }
  arena_sim::MissionOptions mission = options.mission;
  mission.with_odometry = !options.without_odometry;
  arena_sim::writeFlatMission(mission, config, options.out);
}

}  // namespace

void addArenaCommand(CLI::App& app) {
  const auto options = std::make_shared<ArenaOptions>();
  CLI::App* command = app.add_subcommand("arena", "Simulate a mission with exact truth from a seed");
  command->add_option("--mission", options->name, "What the robot does: flat (rooms on one level floor)")
      ->check(CLI::IsMember({"flat"}))
      ->capture_default_str();
  command->add_option("--seed", options->mission.seed, "Same seed, same bytes")->capture_default_str();
  command->add_option("--duration", options->mission.duration_s, "Length of the mission, s")
      ->check(CLI::Range(arena_sim::kShortestMission, 3600.0))
      ->capture_default_str();
  command->add_flag("--without-odometry", options->without_odometry, "Leave ODOMETRY out of the log");
  command
      ->add_option("--config", options->config_files, "YAML with sections robot, arena_sim; later files win")
      ->allow_extra_args(false);
  command->add_option("--set", options->overrides, "One value, e.g. --set arena_sim.lidar.range_sigma=0.03")
      ->allow_extra_args(false);
  command->add_option("--out", options->out, "Folder for mission.lcm, robot.yaml, truth/ and top_view.png")
      ->required();
  command->footer("Example:\n  rubble arena --mission flat --seed 7 --out /tmp/mission\n");
  command->callback([options] { runArena(*options); });
}

}  // namespace rubble::tools
