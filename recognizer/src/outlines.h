#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "quad.h"

namespace rubble::recognizer {

struct Outline {
  Quad quad;
  double fill = 0.0;  ///< share of the quad that the region covers
};

/// Four-sided regions of a BGR picture that stand out from their surroundings: outer and inner contours of
/// level sets of brightness, chroma and saturation, of edges and of local brightness, whose convex hull a
/// quadrilateral fits well. Fullest first, each once. `smallest_side`: pixels.
std::vector<Outline> findOutlines(const cv::Mat& picture, double smallest_side);

}  // namespace rubble::recognizer
