#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "calibration/board.h"
#include "calibration/scan_lines.h"
#include "common/geometry.h"

namespace rubble::calibration {

/// The board as camera and LiDAR saw it at one time.
struct BoardPair {
  std::string name;
  common::Pose3 T_camera_board;
  std::vector<Eigen::Vector2d> points;  // of the whole scan, in frame lidar
  std::vector<ScanLine> lines;          // of the same scan
  /// The square between the first four inner corners is black, its neighbours white, and so on.
  bool is_first_black = true;
};

struct Extrinsics {
  common::Pose3 T_camera_lidar;
  /// Of a turn about the camera's axes (rad) and of the shift along them (m): turn first.
  Eigen::Matrix<double, 6, 1> deviations;
};

/// Many LiDARs measure centimetres too short on black paper (laser_camera's: 2 to 5 cm), so the fit uses
/// white only.
enum class Paper { kAll, kWhite };

/// How far, in m, from the board's plane the points are that lie on its squares (nearer than 0.15 m); signed.
/// White: inside white squares, off their edges.
std::vector<double> distancesToBoard(const Board& board, const BoardPair& pair,
                                     const common::Pose3& T_camera_lidar, Paper paper);

/// In words, of the camera's axes: `the camera's turn about x, shift along y`.
std::string directionsBeyond(const Eigen::Matrix<double, 6, 1>& deviations, double limit);

/// Whether a pair's distances are those of a board and its scan: enough of them, half of them within 3 cm.
bool agrees(std::vector<double> distances);

/// Zhang and Pless, Extrinsic calibration of a camera and laser range finder (IROS 2004): every scan point on
/// the board on white fulfils n^T (R p + t) = d (eq. 3), by least squares with Cauchy's loss. The start is
/// bestStart's; the points on the board are chosen anew in every round. Throws common::Error when there are
/// too few pairs or when they leave a direction open.
Extrinsics fitExtrinsics(const Board& board, const std::vector<BoardPair>& pairs);

/// For every pair T_camera_lidar fitted without it and its neighbours, `folds` fits in all (blocks in the
/// order of the pairs: neighbours look alike). Nothing of a pair is known to its fit.
std::vector<common::Pose3> fitsWithout(const Board& board, const std::vector<BoardPair>& pairs,
                                       std::size_t folds);

}  // namespace rubble::calibration
