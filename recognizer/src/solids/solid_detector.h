#pragma once

#include <cstdint>
#include <functional>
#include <opencv2/core.hpp>
#include <vector>

#include "solids/channels.h"
#include "solids/solid_model.h"

namespace rubble::recognizer {

struct FoundSolid {
  cv::Rect2f box;
  std::uint32_t object_class = 0;
  float score = 0;  ///< 0.5: as typical for its class
};

/// Calls visit(row, column, sum) for every window that the cascade does not reject.
using WindowVisitor = std::function<void(int row, int column, float sum)>;
void scanWindows(const Channels& channels, const SolidModel& model, const WindowVisitor& visit);

/// A picture at several sizes, from large to small, until a window no longer fits. A border is added, so that
/// what lies at the edge is found, too.
struct PyramidLevel {
  Channels channels;
  cv::Point2f scale;  ///< the level's pixels per picture's
  /// A window's object in the picture.
  cv::Rect2f boxOf(const SolidModel& model, int row, int column) const;
};
std::vector<PyramidLevel> makePyramid(const cv::Mat& picture, double smallest_side);

/// Objects of at least `score`, the best first; of overlapping ones the best. `picture`: CV_8UC3 (BGR).
/// `smallest_side`: root of the box's area, pixels.
std::vector<FoundSolid> findSolids(const cv::Mat& picture, const std::vector<SolidModel>& models,
                                   double smallest_side, double score);

}  // namespace rubble::recognizer
