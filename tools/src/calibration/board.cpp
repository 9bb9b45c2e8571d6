#include "calibration/board.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "common/error.h"
#include "text_lines.h"

namespace rubble::calibration {

namespace {

constexpr int kFewestCorners = 3;
constexpr int kMostCorners = 50;

}  // namespace

std::vector<cv::Point3f> Board::points() const {
  std::vector<cv::Point3f> points;
  for (int row = 0; row < corners.height; ++row) {
    for (int column = 0; column < corners.width; ++column) {
      points.emplace_back(static_cast<float>(column * square), static_cast<float>(row * square), 0.0F);
    }
  }
  return points;
}

Board parseBoard(const std::string& corners, double square) {
  Board board{.corners = {}, .square = square};
  tools::Words words(corners, "x");
  try {
    board.corners.width = words.any<int>("number of inner corners in a row");
    board.corners.height = words.any<int>("number of rows of inner corners");
    words.expectEnd();
  } catch (const common::Error& e) {
    throw common::Error(fmt::format("board `{}`: {}; write e.g. 9x6", corners, e.what()));
  }
  if (std::min(board.corners.width, board.corners.height) < kFewestCorners ||
      std::max(board.corners.width, board.corners.height) > kMostCorners) {
    throw common::Error(
        fmt::format("board `{}`: {} to {} inner corners either way", corners, kFewestCorners, kMostCorners));
  }
  if (!(square > 0.0 && square < 1.0)) {
    throw common::Error(fmt::format("board: the side of a square is {} m; give it in metres", square));
  }
  return board;
}

std::optional<std::vector<cv::Point2f>> findCorners(const cv::Mat& grey, const Board& board) {
  std::vector<cv::Point2f> corners;
  if (!cv::findChessboardCornersSB(grey, board.corners, corners, cv::CALIB_CB_NORMALIZE_IMAGE) &&
      !cv::findChessboardCorners(grey, board.corners, corners,
                                 cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE)) {
    return std::nullopt;
  }
  constexpr int kHalfWindow = 5;  // pixels
  constexpr int kIterations = 50;
  constexpr double kEnough = 0.01;  // pixels
  cv::cornerSubPix(grey, corners, {kHalfWindow, kHalfWindow}, {-1, -1},
                   {cv::TermCriteria::COUNT | cv::TermCriteria::EPS, kIterations, kEnough});
  return corners;
}

bool isFirstSquareBlack(const cv::Mat& grey, const Board& board, const std::vector<cv::Point2f>& corners) {
  const auto brightness = [&](int column) {
    const int below = column + board.corners.width;
    const cv::Point2f middle =
        0.25F * (corners[column] + corners[column + 1] + corners[below] + corners[below + 1]);
    cv::Mat patch;
    cv::getRectSubPix(grey, {3, 3}, middle, patch);
    return cv::mean(patch)[0];
  };
  return brightness(0) < brightness(1);
}

common::Pose3 T_camera_board(const Board& board, const Lens& lens, const std::vector<cv::Point2f>& corners) {
  cv::Vec3d rotation;
  cv::Vec3d translation;
  if (!cv::solvePnP(board.points(), lens.undistorted(corners), cv::Matx33d::eye(), cv::noArray(), rotation,
                    translation)) {
    throw common::Error("the board's pose does not follow from its corners");
  }
  return poseFromOpenCv(rotation, translation);
}

double angleBetween(const common::Pose3& T_camera_first, const common::Pose3& T_camera_second) {
  const double cosine = T_camera_first.linear().col(2).dot(T_camera_second.linear().col(2));
  return std::acos(std::min(std::abs(cosine), 1.0));
}

}  // namespace rubble::calibration
