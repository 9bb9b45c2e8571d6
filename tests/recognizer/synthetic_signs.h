#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace rubble::test {

struct Sign {
  std::string name;
  cv::Mat picture;
};

/// Three signs of our own, 256 x 256, BGR.
std::vector<Sign> makeSigns();

/// A textured wall, 640 x 480.
cv::Mat makeWall(int seed);

/// Draws the sign so that its top left, top right, bottom right, bottom left lie at `quad`.
void paste(const cv::Mat& sign, const std::array<cv::Point2f, 4>& quad, cv::Mat* picture);

/// A square about `centre`, turned clockwise by `angle` (rad).
std::array<cv::Point2f, 4> squareAt(cv::Point2f centre, float side, float angle);

}  // namespace rubble::test
