#pragma once

#include <opencv2/core.hpp>

namespace rubble::arena_sim {

/// Symbols in the upper corner of hazard labels.
enum class Symbol { kBomb, kFlame, kFlameOverCircle, kSkull, kBiohazard, kTrefoil, kCorrosion, kCylinder };

/// Draws a symbol about `centre` within `radius` (texels); `ground` is the colour behind it.
void drawSymbol(cv::Mat& picture, Symbol symbol, const cv::Point2d& centre, double radius,
                const cv::Scalar& ink, const cv::Scalar& ground);

}  // namespace rubble::arena_sim
