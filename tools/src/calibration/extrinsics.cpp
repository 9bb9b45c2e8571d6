#include "calibration/extrinsics.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

#include "calibration/extrinsics_start.h"
#include "calibration/plane_fit.h"
#include "common/error.h"
#include "common/statistics.h"

namespace rubble::calibration {

namespace {

constexpr std::size_t kFewestPairs = 5;
constexpr std::size_t kFewestPoints = 8;  // of a pair
constexpr double kNear = 0.15;            // m; wide: a LiDAR's error on black can be 0.06
constexpr int kRounds = 8;

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

bool isWhite(const BoardPair& pair, double column, double row) {
  constexpr double kEdge = 0.15;  // of a square
  const auto isInside = [](double place) {
    const double part = place - std::floor(place);
    return part > kEdge && part < 1.0 - kEdge;
  };
  const bool is_first_color = static_cast<int>(std::floor(column) + std::floor(row)) % 2 == 0;
  return isInside(column) && isInside(row) && is_first_color != pair.is_first_black;
}

/// Where the beam to p meets the board counts, not p: its range may be wrong by centimetres.
bool isOn(Paper paper, const Board& board, const BoardPair& pair, const common::Pose3& T_board_lidar,
          const Eigen::Vector2d& p) {
  const Eigen::Vector3d p_board = T_board_lidar * lifted(p);
  const Eigen::Vector3d origin = T_board_lidar.translation();
  const Eigen::Vector3d hit = origin + (p_board - origin) * (origin.z() / (origin.z() - p_board.z()));
  const double column = hit.x() / board.square;
  const double row = hit.y() / board.square;
  // The squares reach one beyond the inner corners.
  return std::abs(p_board.z()) < kNear && column > -1.0 && column < board.corners.width && row > -1.0 &&
         row < board.corners.height && (paper == Paper::kAll || isWhite(pair, column, row));
}

std::vector<Eigen::Vector2d> pointsOnBoard(const Board& board, const BoardPair& pair,
                                           const common::Pose3& T_camera_lidar, Paper paper) {
  const common::Pose3 T_board_lidar = pair.T_camera_board.inverse() * T_camera_lidar;
  std::vector<Eigen::Vector2d> points;
  for (const Eigen::Vector2d& p : pair.points) {
    if (isOn(paper, board, pair, T_board_lidar, p)) {
      points.push_back(p);
    }
  }
  return points;
}

PlaneFit fitPoints(const Board& board, const std::vector<BoardPair>& pairs,
                   const common::Pose3& T_camera_lidar, Paper paper) {
  std::vector<PointsInPlane> planes;
  for (const BoardPair& pair : pairs) {
    std::vector<Eigen::Vector2d> points = pointsOnBoard(board, pair, T_camera_lidar, paper);
    if (points.size() >= kFewestPoints) {
      const Eigen::Vector3d normal = pair.T_camera_board.linear().col(2);
      planes.push_back({normal, normal.dot(pair.T_camera_board.translation()), std::move(points)});
    }
  }
  return fitPlanes(planes, T_camera_lidar);
}

double medianOfAbsolutes(std::vector<double> values) {
  for (double& value : values) {
    value = std::abs(value);
  }
  return common::statisticsOf(std::move(values)).median;
}

/// Robust against outliers; never below what a LiDAR can be trusted with.
double deviationOf(const std::vector<double>& residuals) {
  constexpr double kLeast = 0.003;               // m
  constexpr double kDeviationOfMedian = 1.4826;  // of a normal distribution
  return std::max(kDeviationOfMedian * medianOfAbsolutes(residuals), kLeast);
}

/// Throws when a direction is known worse than this.
Matrix6 covarianceOf(const PlaneFit& fit) {
  constexpr double kLargestDeviation = 0.1;  // rad or m
  const double noise = deviationOf(fit.residuals);
  const Eigen::SelfAdjointEigenSolver<Matrix6> modes(fit.information / (noise * noise));
  if (modes.eigenvalues()(0) > 1.0 / (kLargestDeviation * kLargestDeviation)) {
    return modes.eigenvectors() * modes.eigenvalues().cwiseInverse().asDiagonal() *
           modes.eigenvectors().transpose();
  }
  Vector6 deviations = Vector6::Zero();
  for (int i = 0; i < 6; ++i) {
    for (int k = 0; k < 6; ++k) {
      const double value = std::max(modes.eigenvalues()(k), 1e-9);
      deviations(i) += modes.eigenvectors()(i, k) * modes.eigenvectors()(i, k) / value;
    }
  }
  deviations = deviations.cwiseSqrt();
  throw common::Error(
      fmt::format("the boards do not determine {}: they stand too much alike; take more pairs with the board "
                  "turned about "
                  "the vertical and tipped forwards and backwards by 20 to 50 degrees, both ways",
                  directionsBeyond(deviations, 0.5 * kLargestDeviation)));
}

}  // namespace

std::vector<double> distancesToBoard(const Board& board, const BoardPair& pair,
                                     const common::Pose3& T_camera_lidar, Paper paper) {
  const common::Pose3 T_board_lidar = pair.T_camera_board.inverse() * T_camera_lidar;
  std::vector<double> distances;
  for (const Eigen::Vector2d& p : pointsOnBoard(board, pair, T_camera_lidar, paper)) {
    distances.push_back((T_board_lidar * lifted(p)).z());
  }
  return distances;
}

std::string directionsBeyond(const Vector6& deviations, double limit) {
  constexpr std::array kNames{"turn about x",  "turn about y",  "turn about z",
                              "shift along x", "shift along y", "shift along z"};
  std::vector<const char*> names;
  for (int i = 0; i < 6; ++i) {
    if (deviations(i) > limit) {
      names.push_back(kNames.at(static_cast<std::size_t>(i)));
    }
  }
  return fmt::format("the camera's {}", fmt::join(names, ", "));
}

bool agrees(std::vector<double> distances) {
  constexpr double kLargestMedian = 0.03;  // m
  return distances.size() >= kFewestPoints && medianOfAbsolutes(std::move(distances)) < kLargestMedian;
}

Extrinsics fitExtrinsics(const Board& board, const std::vector<BoardPair>& pairs) {
  if (pairs.size() < kFewestPairs) {
    throw common::Error(
        fmt::format("{} pairs show the board to the camera; at least {} are needed, 20 are good",
                    pairs.size(), kFewestPairs));
  }
  PlaneFit fit;
  fit.T_camera_lidar = bestStart(board, pairs);
  for (int round = 0; round < kRounds; ++round) {
    fit = fitPoints(board, pairs, fit.T_camera_lidar, round == 0 ? Paper::kAll : Paper::kWhite);
  }
  const auto agreeing =
      static_cast<std::size_t>(std::count_if(pairs.begin(), pairs.end(), [&](const BoardPair& pair) {
        return agrees(distancesToBoard(board, pair, fit.T_camera_lidar, Paper::kWhite));
      }));
  if (agreeing < std::max(kFewestPairs, pairs.size() / 2)) {
    throw common::Error(
        fmt::format("camera and LiDAR agree in only {} of {} pairs: are pictures and scans of the same "
                    "moment, is the board's "
                    "square right, does the LiDAR's plane meet the board?",
                    agreeing, pairs.size()));
  }
  return {fit.T_camera_lidar, covarianceOf(fit).diagonal().cwiseSqrt()};
}

std::vector<common::Pose3> fitsWithout(const Board& board, const std::vector<BoardPair>& pairs,
                                       std::size_t folds) {
  std::vector<common::Pose3> fits;
  for (std::size_t fold = 0; fold < folds; ++fold) {
    const std::size_t begin = pairs.size() * fold / folds;
    const std::size_t end = pairs.size() * (fold + 1) / folds;
    if (begin == end) {
      continue;
    }
    std::vector<BoardPair> others(pairs.begin(), pairs.begin() + static_cast<std::ptrdiff_t>(begin));
    others.insert(others.end(), pairs.begin() + static_cast<std::ptrdiff_t>(end), pairs.end());
    fits.resize(end, fitExtrinsics(board, others).T_camera_lidar);
  }
  return fits;
}

}  // namespace rubble::calibration
