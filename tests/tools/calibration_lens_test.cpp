#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "calibration/lens_fit.h"
#include "support/error_text.h"
#include "support/temp_dir.h"

namespace rubble::calibration {
namespace {

using test::errorOf;
using ::testing::HasSubstr;

const Board kBoard{{9, 6}, 0.09};
const cv::Size kSize{640, 480};

Lens truth(bool is_fisheye) {
  Lens lens;
  lens.size = kSize;
  lens.is_fisheye = is_fisheye;
  lens.K = {370.0, 0.0, 325.0, 0.0, 372.0, 236.0, 0.0, 0.0, 1.0};
  lens.distortion = is_fisheye ? std::vector<double>{0.02, -0.01, 0.002, 0.0}
                               : std::vector<double>{-0.22, 0.045, 0.0006, -0.0004};
  return lens;
}

/// Corners of boards tilted by up to `tilt` (rad), with noise in pixels.
std::vector<BoardPicture> picturesOf(const Lens& lens, int count, double tilt, double noise) {
  cv::RNG random(5);
  std::vector<BoardPicture> pictures;
  for (int i = 0; i < count; ++i) {
    std::vector<cv::Point3f> points = kBoard.points();
    for (cv::Point3f& p : points) {
      p -= cv::Point3f(0.36F, 0.225F, 0.0F);
    }
    const cv::Vec3d rotation(random.uniform(-tilt, tilt), random.uniform(-tilt, tilt),
                             random.uniform(-0.3, 0.3));
    const cv::Vec3d translation(random.uniform(-0.35, 0.35), random.uniform(-0.25, 0.25),
                                random.uniform(0.9, 1.5));
    std::vector<cv::Point2f> corners;
    if (lens.is_fisheye) {
      cv::fisheye::projectPoints(points, corners, rotation, translation, lens.K, lens.distortion);
    } else {
      cv::projectPoints(points, rotation, translation, lens.K, lens.distortion, corners);
    }
    for (cv::Point2f& corner : corners) {
      corner.x += static_cast<float>(random.gaussian(noise));
      corner.y += static_cast<float>(random.gaussian(noise));
    }
    pictures.push_back({std::to_string(i), corners});
  }
  return pictures;
}

void expectTruth(const LensFit& fit, double times) {
  const Lens lens = truth(fit.lens.is_fisheye);
  const std::array errors{fit.lens.K(0, 0) - lens.K(0, 0), fit.lens.K(1, 1) - lens.K(1, 1),
                          fit.lens.K(0, 2) - lens.K(0, 2), fit.lens.K(1, 2) - lens.K(1, 2)};
  for (std::size_t i = 0; i < errors.size(); ++i) {
    EXPECT_LT(std::abs(errors.at(i)), times * fit.deviations.at(i)) << i;
    EXPECT_LT(fit.deviations.at(i), 1.5) << i;
  }
}

TEST(LensFitTest, PinholeIsRecoveredWithinItsDeviations) {
  const LensFit fit = fitLens(kBoard, kSize, picturesOf(truth(false), 25, 0.7, 0.1), false);
  expectTruth(fit, 4.0);
  EXPECT_NEAR(fit.rms, 0.1 * std::sqrt(2.0), 0.015);
  ASSERT_EQ(fit.lens.distortion.size(), 4U);
  EXPECT_NEAR(fit.lens.distortion[0], -0.22, 0.02);
}

TEST(LensFitTest, FisheyeIsRecoveredWithinItsDeviations) {
  expectTruth(fitLens(kBoard, kSize, picturesOf(truth(true), 25, 0.7, 0.1), true), 4.0);
}

TEST(LensFitTest, PicturesThatDoNotFitAreLeftOut) {
  std::vector<BoardPicture> pictures = picturesOf(truth(false), 20, 0.7, 0.1);
  for (std::size_t i = 0; i < pictures[6].corners.size(); i += 2) {
    pictures[6].corners[i] += cv::Point2f(4.0F, 3.0F);
  }
  const LensFit fit = fitLens(kBoard, kSize, pictures, false);
  ASSERT_EQ(fit.left_out.size(), 1U);
  EXPECT_EQ(fit.left_out[0].name, "6");
  expectTruth(fit, 4.0);
}

TEST(LensFitTest, DegeneratePicturesAreRefused) {
  EXPECT_THAT(errorOf([] { fitLens(kBoard, kSize, picturesOf(truth(false), 7, 0.7, 0.1), false); }),
              HasSubstr("7 usable pictures of the board; at least 8"));
  EXPECT_THAT(errorOf([] { fitLens(kBoard, kSize, picturesOf(truth(false), 12, 0.0, 0.1), false); }),
              HasSubstr("focal length"));
}

TEST(LensFitTest, PartsWithoutABoardAreNamed) {
  std::vector<BoardPicture> pictures = picturesOf(truth(false), 30, 0.7, 0.1);
  std::erase_if(pictures, [](const BoardPicture& picture) {
    return std::any_of(picture.corners.begin(), picture.corners.end(),
                       [](const cv::Point2f& corner) { return corner.x > 426.0F && corner.y > 320.0F; });
  });
  EXPECT_THAT(fitLens(kBoard, kSize, pictures, false).uncovered, ::testing::Contains("lower right"));
}

/// A printed board in perspective, and where its inner corners are in it.
cv::Mat drawn(std::vector<cv::Point2f>& corners) {
  constexpr int kSquare = 80;
  cv::Mat paper(9 * kSquare, 12 * kSquare, CV_8UC1, cv::Scalar(230));
  for (int row = 0; row < 7; ++row) {
    for (int column = row % 2; column < 10; column += 2) {
      paper(cv::Rect((column + 1) * kSquare, (row + 1) * kSquare, kSquare, kSquare)) = cv::Scalar(30);
    }
  }
  std::vector<cv::Point2f> on_paper;
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column < 9; ++column) {
      on_paper.emplace_back(static_cast<float>((column + 2) * kSquare) - 0.5F,
                            static_cast<float>((row + 2) * kSquare) - 0.5F);
    }
  }
  const cv::Matx33d homography(0.45, 0.06, 60.0, -0.03, 0.5, 70.0, -1e-4, 5e-5, 1.0);
  cv::perspectiveTransform(on_paper, corners, homography);
  cv::GaussianBlur(paper, paper, {5, 5}, 1.2);
  cv::Mat picture;
  cv::warpPerspective(paper, picture, homography, kSize, cv::INTER_AREA, cv::BORDER_CONSTANT,
                      cv::Scalar(120));
  return picture;
}

TEST(BoardTest, CornersAreFoundToATenthOfAPixel) {
  std::vector<cv::Point2f> truth_corners;
  const cv::Mat picture = drawn(truth_corners);
  auto corners = findCorners(picture, kBoard);
  ASSERT_TRUE(corners);
  if (cv::norm(corners->front() - truth_corners.front()) > 10.0) {
    std::reverse(corners->begin(), corners->end());
  }
  for (std::size_t i = 0; i < corners->size(); ++i) {
    EXPECT_LT(cv::norm((*corners)[i] - truth_corners[i]), 0.1) << i;
  }
}

TEST(PicturesTest, WhatShowsNoBoardIsNamedAndLeftOut) {
  const test::TempDir dir;
  EXPECT_THAT(errorOf([&] { readPictures(dir.path() / "none", kBoard); }), HasSubstr("none: No such file"));
  EXPECT_THAT(errorOf([&] { readPictures(dir.path(), kBoard); }), HasSubstr("has no jpg or png"));
  std::vector<cv::Point2f> corners;
  cv::imwrite((dir.path() / "a.png").string(), drawn(corners));
  dir.write("b.jpg", "no picture");
  cv::imwrite((dir.path() / "c.png").string(), cv::Mat(kSize, CV_8UC1, cv::Scalar(99)));
  cv::imwrite((dir.path() / "d.png").string(), cv::Mat(100, 100, CV_8UC1, cv::Scalar(99)));
  const Pictures pictures = readPictures(dir.path(), kBoard);
  EXPECT_EQ(pictures.with_board.size(), 1U);
  ASSERT_EQ(pictures.left_out.size(), 3U);
  EXPECT_EQ(pictures.left_out[0].why, "is no readable picture");
  EXPECT_EQ(pictures.left_out[1].why, "does not show the whole board");
  EXPECT_THAT(pictures.left_out[2].why, HasSubstr("100 x 100"));
}

}  // namespace
}  // namespace rubble::calibration
