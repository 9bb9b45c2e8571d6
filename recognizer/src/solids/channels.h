#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace rubble::recognizer {

/// Side of a cell, pixels.
inline constexpr int kCellSide = 4;
/// Brightness, two of chroma, gradients' strength, and gradients of six directions.
inline constexpr int kChannels = 10;

/// What a picture looks like, cell by cell (aggregated channel features: Dollar, Appel, Belongie and Perona,
/// "Fast feature pyramids for object detection", PAMI 2014).
struct Channels {
  int rows = 0;  ///< cells
  int columns = 0;
  std::vector<std::uint8_t> values;  ///< by row, column, channel

  int stride() const { return columns * kChannels; }
  const std::uint8_t* at(int row, int column) const {
    return &values[static_cast<std::size_t>(row * stride() + column * kChannels)];
  }
};

/// `picture`: CV_8UC3 (BGR), both sides multiples of kCellSide. Brightness and gradients are relative to
/// their surroundings' of some cells, chroma to the brightness: light may change.
Channels channelsOf(const cv::Mat& picture);

}  // namespace rubble::recognizer
