#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>
#include <memory>
#include <numbers>
#include <string>

#include "calibration/extrinsics.h"
#include "calibration/recording.h"
#include "command.h"
#include "common/config.h"
#include "common/error.h"
#include "common/robot_config.h"
#include "common/statistics.h"

namespace rubble::tools {

namespace {

constexpr std::size_t kFolds = 10;
constexpr double kDegrees = 180.0 / std::numbers::pi;

struct ExtrinsicsOptions {
  std::filesystem::path folder;
  std::string board;
  double square = 0.0;
  std::string robot;
};

/// Of pair i to the i-th extrinsics.
void printDistances(const char* what, const calibration::Board& board,
                    const std::vector<calibration::BoardPair>& pairs,
                    const std::vector<common::Pose3>& fits) {
  for (const calibration::Paper paper : {calibration::Paper::kWhite, calibration::Paper::kAll}) {
    std::vector<double> distances;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      for (const double distance : calibration::distancesToBoard(board, pairs[i], fits[i], paper)) {
        distances.push_back(std::abs(distance));
      }
    }
    fmt::print(stderr, "  pairs {}, {}: median {:.4f} m, 90 % {:.4f} m, {} points\n", what,
               paper == calibration::Paper::kWhite ? "white squares" : "all squares",
               common::statisticsOf(distances).median, common::quantileOf(distances, 0.9), distances.size());
  }
}

void printMount(const common::Pose3& T_body_camera) {
  const common::RollPitchYaw rpy = common::rpyFromRotation(T_body_camera.linear());
  const Eigen::Vector3d p = T_body_camera.translation();
  fmt::print(
      "robot:\n"
      "  camera:\n"
      "    translation: [{:.4f}, {:.4f}, {:.4f}]\n"
      "    rpy: [{:.5f}, {:.5f}, {:.5f}]\n",
      p.x(), p.y(), p.z(), rpy.roll, rpy.pitch, rpy.yaw);
}

void calibrateExtrinsics(const ExtrinsicsOptions& options) {
  common::Config config;
  if (!options.robot.empty()) {
    config.addFile(options.robot);
  }
  const auto robot = config.read<common::RobotConfig>("robot");
  calibration::Calib calib;
  const std::filesystem::path calib_file = options.folder / "calib.txt";
  if (std::filesystem::exists(calib_file) || options.robot.empty()) {
    calib = calibration::readCalib(calib_file);
  } else {
    calib.lens = calibration::lensFromConfig(robot.intrinsics);
  }
  if (!options.board.empty()) {
    calib.board = calibration::parseBoard(options.board, options.square);
  } else if (!calib.board) {
    throw common::Error(
        fmt::format("{}: does not name the board; give --board and --square", calib_file.string()));
  }
  const calibration::Board& board = *calib.board;
  const calibration::Pairs pairs = calibration::readPairs(options.folder, calib.lens, board);
  calibration::printLeftOut(pairs.left_out);

  const calibration::Extrinsics fit = calibration::fitExtrinsics(board, pairs.used);
  for (const calibration::BoardPair& pair : pairs.used) {
    if (!calibration::agrees(
            calibration::distancesToBoard(board, pair, fit.T_camera_lidar, calibration::Paper::kWhite))) {
      calibration::printLeftOut(
          {{pair.name,
            "counts little: half of its scan's points are 3 cm or more from the board, or too few are "
            "on it"}});
    }
  }
  fmt::print(stderr, "{} pairs; |distance| of board and scan:\n", pairs.used.size());
  const std::vector<common::Pose3> all(pairs.used.size(), fit.T_camera_lidar);
  printDistances("in the fit", board, pairs.used, all);
  printDistances("left out of the fit", board, pairs.used,
                 calibration::fitsWithout(board, pairs.used, kFolds));
  fmt::print(stderr,
             "1 sigma: turn about camera's x, y, z {:.2f}, {:.2f}, {:.2f} degrees; shift {:.1f}, {:.1f}, "
             "{:.1f} mm\n",
             fit.deviations(0) * kDegrees, fit.deviations(1) * kDegrees, fit.deviations(2) * kDegrees,
             fit.deviations(3) * 1e3, fit.deviations(4) * 1e3, fit.deviations(5) * 1e3);
  constexpr double kWeak = 0.02;  // rad or m
  if (fit.deviations.maxCoeff() > kWeak) {
    fmt::print(stderr,
               "the boards hardly determine {}: take more pairs, tipped and turned more, near and far\n",
               calibration::directionsBeyond(fit.deviations, kWeak));
  }
  const Eigen::Matrix4d& T = fit.T_camera_lidar.matrix();
  for (int row = 0; row < 3; ++row) {
    fmt::print("# {} [{:9.6f} {:9.6f} {:9.6f} {:9.6f}]\n", row == 0 ? "T_camera_lidar" : "              ",
               T(row, 0), T(row, 1), T(row, 2), T(row, 3));
  }
  if (!options.robot.empty()) {
    printMount(robot.T_body_lidar() * fit.T_camera_lidar.inverse());
  }
}

}  // namespace

void addCalibrateExtrinsics(CLI::App& parent) {
  const auto options = std::make_shared<ExtrinsicsOptions>();
  CLI::App* command = parent.add_subcommand(
      "extrinsics", "Where the LiDAR sits from the camera, from a chessboard that both see");
  command->add_option("FOLDER", options->folder, "Pairs of picture and scan, see below")->required();
  CLI::Option* board =
      command->add_option("--board", options->board, "Inner corners, e.g. 9x6; else calib.txt's");
  CLI::Option* square = command->add_option("--square", options->square, "Side of a square in m");
  board->needs(square);
  square->needs(board);
  command->add_option(
      "--robot", options->robot,
      "robot.yaml: prints the camera's mount from the LiDAR's in it; its lens where FOLDER has no "
      "calib.txt");
  command->footer(
      "FOLDER holds\n"
      "  images.csv  `index,file` per line, the file's path within FOLDER\n"
      "  scans.csv   `index,angle_min,angle_step,range,range,...`: radians, metres, counter-clockwise from "
      "x;\n"
      "              `inf` is no echo. The same index is the same moment: the board stands still.\n"
      "  calib.txt   `key value` per line: model pinhole|fisheye, width, height, fx, fy, cx, cy, k1, k2, p1, "
      "p2\n"
      "              [, k3] (fisheye: k1 .. k4), and board_inner_corners 9 6, board_square_m 0.09\n"
      "The result goes to stdout, what it is worth to stderr (docs/calibration.md).\n"
      "Example:\n  rubble calibrate extrinsics pairs --robot robot.yaml\n");
  command->callback([options] { calibrateExtrinsics(*options); });
}

}  // namespace rubble::tools
