#include "calibration/extrinsics_start.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "calibration/plane_fit.h"

namespace rubble::calibration {

namespace {

constexpr std::size_t kStarts = 2000;                   // Rotations about 15 degrees apart.
constexpr std::size_t kStartsToFit = 20;                // The best of them.
constexpr std::array kGates{0.5, 0.5, 0.2, 0.1, 0.05};  // m, root of the mean square to the board's plane

double rmsToBoard(const BoardPair& pair, const ScanLine& line, const common::Pose3& T_camera_lidar) {
  const Eigen::Vector3d normal = pair.T_camera_board.linear().col(2);
  const Eigen::Vector3d origin = pair.T_camera_board.translation();
  const double first = normal.dot(T_camera_lidar * lifted(line.first) - origin);
  const double second = normal.dot(T_camera_lidar * lifted(line.second) - origin);
  return std::sqrt(0.5 * (first * first + second * second));
}

bool isOnBoard(const Board& board, const BoardPair& pair, const ScanLine& line,
               const common::Pose3& T_camera_lidar, double gate) {
  const double margin = board.square + gate;
  const double width = (board.corners.width - 1) * board.square;
  const double height = (board.corners.height - 1) * board.square;
  const Eigen::Vector3d middle = pair.T_camera_board.inverse() * (T_camera_lidar * lifted(line.middle()));
  return line.length < std::hypot(width + 4.0 * board.square, height + 4.0 * board.square) &&
         middle.x() > -margin && middle.x() < width + margin && middle.y() > -margin &&
         middle.y() < height + margin;
}

/// The smaller, the more pairs have a line on their board.
double misfit(const Board& board, const std::vector<BoardPair>& pairs, const common::Pose3& T_camera_lidar,
              double gate) {
  double sum = 0.0;
  for (const BoardPair& pair : pairs) {
    double nearest = gate;
    for (const ScanLine& line : pair.lines) {
      if (isOnBoard(board, pair, line, T_camera_lidar, gate)) {
        nearest = std::min(nearest, rmsToBoard(pair, line, T_camera_lidar));
      }
    }
    sum += nearest;
  }
  return sum;
}

/// Evenly over all rotations (Alexa, Super-Fibonacci spirals, CVPR 2022, algorithm 1).
Eigen::Quaterniond rotationOfMany(std::size_t i, std::size_t n) {
  constexpr double kPhi = std::numbers::sqrt2;
  constexpr double kPsi = 1.533751168755204288118041;
  const double s = static_cast<double>(i) + 0.5;
  const double share = s / static_cast<double>(n);
  const double inner = std::sqrt(share);
  const double outer = std::sqrt(1.0 - share);
  const double alpha = 2.0 * std::numbers::pi * s / kPhi;
  const double beta = 2.0 * std::numbers::pi * s / kPsi;
  return {outer * std::cos(beta), inner * std::sin(alpha), inner * std::cos(alpha), outer * std::sin(beta)};
}

PlaneFit fitLines(const Board& board, const std::vector<BoardPair>& pairs,
                  const common::Pose3& T_camera_lidar, double gate) {
  std::vector<PointsInPlane> planes;
  for (const BoardPair& pair : pairs) {
    const Eigen::Vector3d normal = pair.T_camera_board.linear().col(2);
    for (const ScanLine& line : pair.lines) {
      if (isOnBoard(board, pair, line, T_camera_lidar, gate) &&
          rmsToBoard(pair, line, T_camera_lidar) < gate) {
        planes.push_back({normal, normal.dot(pair.T_camera_board.translation()), {line.first, line.second}});
      }
    }
  }
  return fitPlanes(planes, T_camera_lidar);
}

}  // namespace

common::Pose3 bestStart(const Board& board, const std::vector<BoardPair>& pairs) {
  std::vector<std::pair<double, std::size_t>> starts;
  for (std::size_t i = 0; i < kStarts; ++i) {
    const common::Pose3 T_camera_lidar(rotationOfMany(i, kStarts));
    starts.emplace_back(misfit(board, pairs, T_camera_lidar, kGates.front()), i);
  }
  std::partial_sort(starts.begin(), starts.begin() + kStartsToFit, starts.end());
  common::Pose3 best = common::Pose3::Identity();
  double smallest = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < kStartsToFit; ++k) {
    common::Pose3 T_camera_lidar(rotationOfMany(starts[k].second, kStarts));
    for (const double gate : kGates) {
      T_camera_lidar = fitLines(board, pairs, T_camera_lidar, gate).T_camera_lidar;
    }
    const double left = misfit(board, pairs, T_camera_lidar, kGates.back());
    if (left < smallest) {
      smallest = left;
      best = T_camera_lidar;
    }
  }
  return best;
}

}  // namespace rubble::calibration
