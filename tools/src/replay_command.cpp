#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "command.h"
#include "replay.h"

namespace rubble::tools {

void addReplayCommand(CLI::App& app) {
  struct Arguments {
    std::string log;
    std::string out;
    std::vector<std::string> only;
    std::vector<std::string> config_files;
    std::vector<std::string> overrides;
  };
  const auto arguments = std::make_shared<Arguments>();
  CLI::App* command =
      app.add_subcommand("replay", "Run the processes over a log's sensors, without bus or clock");
  command->add_option("log", arguments->log, "LCM event log")->required();
  command->add_option("--out", arguments->out, "Folder for trajectories, maps, health.json and timing.json")
      ->required();
  command->add_option("--only", arguments->only, "Components to run, e.g. slam_lidar (default: all)")
      ->delimiter(',');
  command
      ->add_option("--config", arguments->config_files,
                   "YAML with sections named after components; later files win (default: robot.yaml beside "
                   "the log, if there)")
      ->allow_extra_args(false);
  command->add_option("--set", arguments->overrides, "One value, e.g. --set slam_lidar.map.cell_size=0.1")
      ->allow_extra_args(false);
  command->footer("Example:\n  rubble replay mission.lcm --out out/ --set slam_lidar.use_odometry=false\n");
  command->callback([arguments] {
    ReplayOptions options;
    options.log = arguments->log;
    options.out_dir = arguments->out;
    options.only = arguments->only;
    for (const std::string& file : arguments->config_files) {
      options.config.addFile(file);
    }
    const std::filesystem::path beside = options.log.parent_path() / "robot.yaml";
    if (arguments->config_files.empty() && std::filesystem::exists(beside)) {
      fmt::print(stderr, "replay: calibration from {}\n", beside.string());
      options.config.addFile(beside);
    }
    for (const std::string& assignment : arguments->overrides) {
      options.config.addOverride(assignment);
    }
    replay(options);
  });
}

}  // namespace rubble::tools
