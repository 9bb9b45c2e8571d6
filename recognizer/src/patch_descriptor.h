#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

namespace rubble::recognizer {

/// Side of a rectified patch, pixels.
inline constexpr int kPatchSide = 48;
/// 12 x 12 cells of brightness, 6 x 6 of chroma (2) and of gradients by direction (8).
inline constexpr int kPatchDimensions = 12 * 12 + 6 * 6 * 2 + 6 * 6 * 8;

using PatchDescriptor = Eigen::VectorXf;

/// The look of a CV_8UC3 (BGR) patch: brightness up to gain and offset, chroma up to gain, histograms of
/// oriented gradients (Dalal and Triggs, CVPR 2005) up to gain.
PatchDescriptor describePatch(const cv::Mat& patch);

/// Where the elements of a descriptor come from when the patch's top right corner becomes its top left:
/// turned[i] = descriptor[quarterTurn()[i]].
const std::vector<int>& quarterTurn();
PatchDescriptor turned(const PatchDescriptor& descriptor);

}  // namespace rubble::recognizer
