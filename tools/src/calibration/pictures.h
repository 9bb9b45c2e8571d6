#pragma once

#include <filesystem>
#include <opencv2/core/types.hpp>
#include <string>
#include <vector>

#include "calibration/board.h"

namespace rubble::calibration {

/// A picture that is not used.
struct LeftOut {
  std::string name;
  std::string why;
};

/// A line on stderr for each.
void printLeftOut(const std::vector<LeftOut>& left_out);

/// The board in one picture.
struct BoardPicture {
  std::string name;
  std::vector<cv::Point2f> corners;
};

struct Pictures {
  cv::Size size;
  std::vector<BoardPicture> with_board;
  std::vector<LeftOut> left_out;
};

/// Every jpg and png of a folder, by name. Leaves out what is unreadable, of another size than the first, or
/// does not show the whole board. Throws common::Error for a folder without pictures.
Pictures readPictures(const std::filesystem::path& folder, const Board& board);

}  // namespace rubble::calibration
