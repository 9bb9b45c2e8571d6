#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <span>
#include <vector>

namespace rubble::orb {

struct Corner {
  std::int16_t x = 0;  ///< pixels
  std::int16_t y = 0;
  std::uint8_t score = 0;  ///< the largest threshold at which it still is a corner
};

/// FAST-9 corners (Rosten and Drummond, "Machine learning for high-speed corner detection", ECCV 2006) of one
/// picture: of 3 x 3 pixels the one with the highest score, of equal ones the first. Cells with a corner at
/// `threshold` keep only such, others keep those at `min_threshold`. Keeps its buffers.
class FastDetector {
 public:
  /// Corners keep this distance from the picture's border, so that descriptors' patches fit.
  static constexpr int kEdge = 19;
  static constexpr int kCellSize = 35;  ///< pixels, about

  /// 0 < min_threshold <= threshold < 255
  FastDetector(int threshold, int min_threshold);

  /// Row by row; `corners` is overwritten. Pictures too small for a corner have none.
  void detect(const cv::Mat& grey, std::vector<Corner>* corners);

  /// Where the score peaks next to each of the corners, from the pixel's centre: a parabola in x and one in y
  /// through the scores of 3 x 3 pixels. Takes two thirds off the error of whole pixels.
  static void refine(const cv::Mat& grey, std::span<const Corner> corners, cv::Point2f* offsets);

 private:
  void keepStrongInCells(int width, int height, std::vector<Corner>* corners);

  std::uint8_t threshold_;
  std::uint8_t min_threshold_;
  std::vector<std::uint8_t> strengths_;  // three rows of the picture
  std::vector<std::uint8_t> strongest_;  // score per cell
};

}  // namespace rubble::orb
