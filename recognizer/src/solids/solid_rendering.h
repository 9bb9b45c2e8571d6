#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "rendering.h"

namespace rubble::recognizer {

/// Cells that are rendered around a window, so that its channels know their surroundings.
inline constexpr int kRenderedMargin = 7;

/// A sample cut out, hardly larger than it is needed.
struct CutOut {
  cv::Mat colours;   ///< CV_32FC3, 0 .. 1, times coverage
  cv::Mat coverage;  ///< CV_32FC1, 0 .. 1
  cv::Rect2f box;    ///< the object's
};
CutOut cutOut(const SamplePicture& sample);

/// The sample before a background as a window of `window` pixels with kRenderedMargin cells around it: a
/// little off its place, turned, mirrored, in other light, partly hidden. `background`: at least as large.
cv::Mat renderSolid(const CutOut& sample, const cv::Mat& background, cv::Size window, cv::RNG* random);

/// A piece of one of the pictures, `size` pixels, at a random scale.
cv::Mat cropAnywhere(const std::vector<cv::Mat>& pictures, cv::Size size, cv::RNG* random);

}  // namespace rubble::recognizer
