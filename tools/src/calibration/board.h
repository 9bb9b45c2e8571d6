#pragma once

#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "calibration/lens.h"
#include "common/geometry.h"

namespace rubble::calibration {

/// A printed chessboard. Frame `board`: origin in the first inner corner, x along a row of inner corners, z =
/// 0 on the paper.
struct Board {
  cv::Size corners;     // inner ones, where black squares touch
  double square = 0.0;  // m

  /// Row by row, as findCorners gives them.
  std::vector<cv::Point3f> points() const;
};

/// `9x6` inner corners and the side of a square in metres. Throws common::Error.
Board parseBoard(const std::string& corners, double square);

/// Pixels of all inner corners, row by row; none unless the whole board is in the grey picture.
std::optional<std::vector<cv::Point2f>> findCorners(const cv::Mat& grey, const Board& board);

/// Whether the square between the first four inner corners is darker than the next of its row.
bool isFirstSquareBlack(const cv::Mat& grey, const Board& board, const std::vector<cv::Point2f>& corners);

/// Where the board lies: perspective-n-point on the undistorted corners. Throws common::Error.
common::Pose3 T_camera_board(const Board& board, const Lens& lens, const std::vector<cv::Point2f>& corners);

/// Of two boards' planes, 0 .. pi/2.
double angleBetween(const common::Pose3& T_camera_first, const common::Pose3& T_camera_second);

}  // namespace rubble::calibration
