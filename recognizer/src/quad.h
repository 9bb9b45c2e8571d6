#pragma once

#include <array>
#include <opencv2/core.hpp>

namespace rubble::recognizer {

/// Top left, top right, bottom right, bottom left of a sample: clockwise as seen (x right, y down).
using Quad = std::array<cv::Point2f, 4>;

/// Signed: positive where the corners run clockwise as seen.
double areaOf(const Quad& quad);
/// Convex, clockwise, and its longest side at most `ratio` times its shortest.
bool isPlausible(const Quad& quad, double ratio);
cv::Point2f centreOf(const Quad& quad);
/// About the centre.
Quad scaled(const Quad& quad, float factor);
/// The same outline begun at another corner.
Quad turned(const Quad& quad, int quarters);
/// Mean corner distance of two outlines, begun wherever they agree best.
double distanceOf(const Quad& a, const Quad& b);
cv::Rect2f boundsOf(const Quad& quad);
Quad quadOf(const cv::Rect2f& box);
/// Share of the smaller of two rectangles that lies in the other one, and intersection over union.
double containment(const cv::Rect2f& a, const cv::Rect2f& b);
double overlap(const cv::Rect2f& a, const cv::Rect2f& b);

/// Between pictures of two sizes; the first pixel's centre is 0.
cv::Point2f rescaled(const cv::Point2f& point, float factor);
Quad rescaled(const Quad& quad, float factor);

/// What lies within `quad`, as a square of `side` pixels, averaged against aliasing. Beyond the picture its
/// border is repeated.
cv::Mat rectified(const cv::Mat& picture, const Quad& quad, int side);

}  // namespace rubble::recognizer
