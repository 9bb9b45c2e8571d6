#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <opencv2/core/utils/logger.hpp>
#include <string>

#include "command.h"

namespace {

enum ExitStatus { kDone = 0, kFailed = 1, kUsage = 2 };

}  // namespace

int main(int argc, char** argv) {
  using namespace rubble::tools;
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  CLI::App app("Rubble: SLAM for rescue robots. Recordings, replay, evaluation and checks.", "rubble");
  app.require_subcommand(1);
  app.footer(
      "`rubble COMMAND --help` explains one.\nExample:\n  rubble import carmen fr079.clf.bz2 --out "
      "fr079.lcm\n");
  addImportCommand(app);
  addExportCommand(app);
  addReplayCommand(app);
  addPlayCommand(app);
  addEvalCommand(app);
  addArenaCommand(app);
  addExperimentCommand(app);
  addEmulateCommand(app);
  addDoctorCommand(app);
  addSpyCommand(app);
  addTrainCommand(app);
  addCalibrateCommand(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? kDone : kUsage;
  } catch (const std::exception& e) {
    std::string line = e.what();
    std::replace(line.begin(), line.end(), '\n', ' ');
    fmt::print(stderr, "rubble: {}\n", line);
    return kFailed;
  }
  return kDone;
}
