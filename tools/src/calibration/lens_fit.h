#pragma once

#include <array>
#include <opencv2/core/types.hpp>
#include <string>
#include <vector>

#include "calibration/board.h"
#include "calibration/lens.h"
#include "calibration/pictures.h"

namespace rubble::calibration {

struct LensFit {
  Lens lens;
  std::vector<std::string> used;
  std::vector<LeftOut> left_out;  // Pictures that do not fit to the others.
  double rms = 0.0;               // reprojection error, pixels
  /// Standard deviations of fx, fy, cx, cy, in pixels, from the residuals.
  std::array<double, 4> deviations{};
  /// Parts of the picture in which no board was seen, e.g. "upper left".
  std::vector<std::string> uncovered;
};

/// Zhang, A flexible new technique for camera calibration (PAMI 2000) as OpenCV has it, for pinhole (k1 k2 p1
/// p2) or fisheye (k1 .. k4, equidistant). Leaves out, worst first, pictures whose reprojection error is far
/// above the others'. Throws common::Error with fewer than 8 usable pictures, or when the boards stand so
/// much alike that the focal length does not follow.
LensFit fitLens(const Board& board, cv::Size size, std::vector<BoardPicture> pictures, bool is_fisheye);

}  // namespace rubble::calibration
