#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "command.h"
#include "export_carmen.h"
#include "export_results.h"
#include "export_tum.h"

namespace rubble::tools {

namespace {

void addExporter(CLI::App& parent, const char* name, const char* purpose, const char* out,
                 const char* example,
                 void (*run)(const std::filesystem::path&, const std::filesystem::path&)) {
  struct Paths {
    std::string log;
    std::string out;
  };
  const auto paths = std::make_shared<Paths>();
  CLI::App* app = parent.add_subcommand(name, purpose);
  app->add_option("LOG", paths->log, "LCM log to read")->required();
  app->add_option("--out", paths->out, "Where to write")->required()->option_text(out);
  app->footer(std::string("Example:\n  ") + example + "\n");
  app->callback([paths, run] { run(paths->log, paths->out); });
}

}  // namespace

void addExportCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand("export", "Turn an LCM log into files that other systems read");
  command->require_subcommand(1);
  command->footer("Example:\n  rubble export tum mission.lcm --out mission_tum\n");
  addExporter(*command, "tum",
              "rgb.txt, pictures (JPEG bytes untouched, else PNG), calib.txt, and groundtruth.txt if known",
              "DIR", "rubble export tum mission.lcm --out mission_tum", exportTum);
  addExporter(
      *command, "carmen",
      "CARMEN log: ODOM lines and FLASER with the nearest odometry (ROBOTLASER1 where the beams are not "
      "FLASER's 180 degrees)",
      "FILE", "rubble export carmen mission.lcm --out mission.clf", exportCarmen);
  addExporter(
      *command, "results",
      "What the processes published live, as the result files of `rubble replay`: trajectories, maps, "
      "poses.csv",
      "DIR", "rubble export results mission.lcm --out mission_results", exportResults);
}

}  // namespace rubble::tools
