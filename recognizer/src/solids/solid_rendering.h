#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "rendering.h"

namespace rubble::recognizer {

/// Cells that are rendered around a window, so that its channels know their surroundings.
inline constexpr int kRenderedMargin = 7;

/// The sample before a background as a window of `window` pixels with kRenderedMargin cells around it: a little
/// off its place, turned, mirrored, in other light, partly hidden. `background`: at least as large.
cv::Mat renderSolid(const SamplePicture& sample, const cv::Mat& background, cv::Size window, cv::RNG* random);

/// A piece of one of the pictures, `size` pixels, at a random scale.
cv::Mat cropAnywhere(const std::vector<cv::Mat>& pictures, cv::Size size, cv::RNG* random);

}  // namespace rubble::recognizer
