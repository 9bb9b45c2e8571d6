#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <string>

#include "calibration/lens_fit.h"
#include "command.h"
#include "common/error.h"
#include "common/files.h"

namespace rubble::tools {

namespace {

struct CameraOptions {
  std::filesystem::path pictures;
  std::string board;
  double square = 0.0;
  std::string model = "pinhole";
  std::string out;
};

std::string yamlOf(const calibration::Lens& lens) {
  return fmt::format(
      "robot:\n"
      "  camera:\n"
      "    width: {}\n"
      "    height: {}\n"
      "    model: {}\n"
      "    focal: [{:.3f}, {:.3f}]\n"
      "    centre: [{:.3f}, {:.3f}]\n"
      "    distortion: [{:.6f}]\n",
      lens.size.width, lens.size.height, lens.is_fisheye ? "fisheye" : "pinhole", lens.K(0, 0), lens.K(1, 1),
      lens.K(0, 2), lens.K(1, 2), fmt::join(lens.distortion, ", "));
}

void calibrateCamera(const CameraOptions& options) {
  if (std::filesystem::exists(options.out)) {
    throw common::Error(
        fmt::format("{}: exists; --out writes only robot.camera's lens, so give a new name", options.out));
  }
  const calibration::Board board = calibration::parseBoard(options.board, options.square);
  calibration::Pictures pictures = calibration::readPictures(options.pictures, board);
  calibration::printLeftOut(pictures.left_out);
  const calibration::LensFit fit =
      calibration::fitLens(board, pictures.size, std::move(pictures.with_board), options.model == "fisheye");
  calibration::printLeftOut(fit.left_out);
  fmt::print(stderr, "{} pictures used, reprojection error {:.3f} pixels (root of the mean square)\n",
             fit.used.size(), fit.rms);
  fmt::print(stderr, "focal +- {:.2f}, {:.2f}, centre +- {:.2f}, {:.2f} pixels (1 sigma)\n",
             fit.deviations[0], fit.deviations[1], fit.deviations[2], fit.deviations[3]);
  if (!fit.uncovered.empty()) {
    fmt::print(stderr,
               "no board was seen in these parts of the picture, where the distortion is a guess: {}\n",
               fmt::join(fit.uncovered, ", "));
  }
  if (options.out.empty()) {
    fmt::print("{}", yamlOf(fit.lens));
  } else {
    common::writeFileAtomically(options.out, yamlOf(fit.lens));
  }
}

}  // namespace

void addCalibrateCamera(CLI::App& parent) {
  const auto options = std::make_shared<CameraOptions>();
  CLI::App* command = parent.add_subcommand("camera", "The lens, from pictures of a chessboard");
  command->add_option("PICTURES_DIR", options->pictures, "jpg and png pictures, 20 or more")->required();
  command->add_option("--board", options->board, "Inner corners, e.g. 9x6")->required();
  command->add_option("--square", options->square, "Side of a square in m")->required();
  command->add_option("--model", options->model, "pinhole, or fisheye (beyond 120 degrees)")
      ->check(CLI::IsMember({"pinhole", "fisheye"}))
      ->capture_default_str();
  command->add_option("--out", options->out, "New YAML file; else it goes to stdout");
  command->footer(
      "The result is the section robot.camera as config/robot.yaml has it; what it is worth goes to stderr.\n"
      "Example:\n  rubble calibrate camera pictures --board 9x6 --square 0.09 --out lens.yaml\n");
  command->callback([options] { calibrateCamera(*options); });
}

void addCalibrateCommand(CLI::App& app) {
  CLI::App* calibrate =
      app.add_subcommand("calibrate", "The camera's lens, and the camera against the LiDAR");
  calibrate->require_subcommand(1);
  calibrate->footer("Example:\n  rubble calibrate camera pictures --board 9x6 --square 0.09\n");
  addCalibrateCamera(*calibrate);
  addCalibrateExtrinsics(*calibrate);
}

}  // namespace rubble::tools
