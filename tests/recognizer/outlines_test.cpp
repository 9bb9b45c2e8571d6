#include "outlines.h"

#include <gtest/gtest.h>

#include <cmath>

#include "synthetic_signs.h"

namespace rubble::recognizer {
namespace {

TEST(Outlines, FindsSignsOfAnySizeAndTurn) {
  const auto signs = test::makeSigns();
  for (const float side : {24.0F, 60.0F, 150.0F}) {
    for (const float angle : {0.0F, 0.4F, 0.785F}) {
      cv::Mat picture = test::makeWall(3);
      const Quad truth = test::squareAt({320.0F, 240.0F}, side, angle);
      test::paste(signs[1].picture, truth, &picture);
      double nearest = 1e9;
      for (const Outline& outline : findOutlines(picture, 18.0)) {
        nearest = std::min(nearest, distanceOf(outline.quad, truth));
      }
      EXPECT_LT(nearest, 1.5 + 0.06 * static_cast<double>(side)) << side << " px turned by " << angle;
    }
  }
}

TEST(Outlines, AreClockwiseConvexAndLargeEnough) {
  cv::Mat picture = test::makeWall(4);
  test::paste(test::makeSigns()[0].picture, test::squareAt({200.0F, 200.0F}, 90.0F, 0.2F), &picture);
  for (const Outline& outline : findOutlines(picture, 30.0)) {
    EXPECT_TRUE(isPlausible(outline.quad, 4.0));
    EXPECT_GE(areaOf(outline.quad), 900.0);
  }
}

TEST(Outlines, FindsNothingOnAPlainPicture) {
  EXPECT_TRUE(findOutlines(cv::Mat(480, 640, CV_8UC3, cv::Scalar(90, 90, 90)), 18.0).empty());
}

}  // namespace
}  // namespace rubble::recognizer
