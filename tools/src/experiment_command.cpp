#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "command.h"
#include "experiment.h"

namespace rubble::tools {

void addExperimentCommand(CLI::App& app) {
  struct Arguments {
    std::string seeds = "1..20";
    std::string mission = "rescue";
    double duration_s = 0.0;
    std::string out;
    std::vector<std::string> config_files;
    std::vector<std::string> overrides;
  };
  const auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand(
      "experiment",
      "Grid SLAM alone, lsm, lsm-robust, joint and joint less each factor on the same arena missions");
  command->add_option("--seeds", arguments->seeds, "e.g. 7, 1..20 or 1,4,8..10")->capture_default_str();
  command->add_option("--mission", arguments->mission, "As of `rubble arena`")
      ->check(CLI::IsMember({"flat", "rescue", "tour"}))
      ->capture_default_str();
  command->add_option("--duration", arguments->duration_s, "Longest drive, s (default: as of `rubble arena`)")
      ->check(CLI::Range(arena_sim::kShortestMission, 3600.0));
  command
      ->add_option("--config", arguments->config_files,
                   "YAML with sections robot, arena_sim, slam_mono, slam_lidar, fusion; later files win")
      ->allow_extra_args(false);
  command->add_option("--set", arguments->overrides, "One value, e.g. --set fusion.window=5")
      ->allow_extra_args(false);
  command->add_option("--out", arguments->out, "Folder for report.md and, per seed, truth, results and maps")
      ->required();
  command->footer(
      "Missions are made once and kept in ~/.cache/rubble/arena: some minutes each.\n"
      "Example:\n  rubble experiment --seeds 1..3 --mission rescue --duration 160 --out experiment\n");
  command->callback([arguments] {
    ExperimentOptions options;
    options.seeds = parseSeeds(arguments->seeds);
    options.mission.kind = arguments->mission;
    if (arguments->duration_s > 0.0) {
      options.mission.duration_s = arguments->duration_s;
    }
    options.mission.cache = arena_sim::userCache();
    options.out_dir = arguments->out;
    for (const std::string& file : arguments->config_files) {
      options.config.addFile(file);
    }
    for (const std::string& assignment : arguments->overrides) {
      options.config.addOverride(assignment);
    }
    runExperiment(options);
    fmt::print("{}\n", (options.out_dir / "report.md").string());
  });
}

}  // namespace rubble::tools
