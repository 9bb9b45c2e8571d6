#include "fast_detector.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <opencv2/imgproc.hpp>
#include <tuple>
#include <utility>

namespace rubble::orb {

bool operator==(const Corner& a, const Corner& b) {
  return std::tie(a.x, a.y, a.score) == std::tie(b.x, b.y, b.score);
}

namespace {

constexpr int kThreshold = 20;
constexpr int kMinThreshold = 7;

bool isCorner(const cv::Mat& picture, int x, int y, int threshold) {
  constexpr std::array<std::array<int, 2>, 16> kCircle = {{{0, -3},
                                                           {1, -3},
                                                           {2, -2},
                                                           {3, -1},
                                                           {3, 0},
                                                           {3, 1},
                                                           {2, 2},
                                                           {1, 3},
                                                           {0, 3},
                                                           {-1, 3},
                                                           {-2, 2},
                                                           {-3, 1},
                                                           {-3, 0},
                                                           {-3, -1},
                                                           {-2, -2},
                                                           {-1, -3}}};
  const int centre = picture.at<std::uint8_t>(y, x);
  for (const int sign : {-1, 1}) {
    int run = 0;
    for (std::size_t i = 0; i < 16 + 8; ++i) {
      const auto& [dx, dy] = kCircle[i % 16];
      const int difference = sign * (picture.at<std::uint8_t>(y + dy, x + dx) - centre);
      run = difference > threshold ? run + 1 : 0;
      if (run == 9) {
        return true;
      }
    }
  }
  return false;
}

/// The largest threshold, -1 where even the smallest is too much.
int slowScore(const cv::Mat& picture, int x, int y) {
  constexpr int kEdge = FastDetector::kEdge;
  if (x < kEdge || y < kEdge || x >= picture.cols - kEdge || y >= picture.rows - kEdge) {
    return -1;
  }
  int score = -1;
  while (score < 255 && isCorner(picture, x, y, std::max(score + 1, kMinThreshold))) {
    score = std::max(score + 1, kMinThreshold);
  }
  return score;
}

int cellOf(int position, int size) {
  const int span = size - 2 * FastDetector::kEdge;
  const int count = std::max(1, (span + FastDetector::kCellSize / 2) / FastDetector::kCellSize);
  return (position - FastDetector::kEdge) * count / span;
}

std::vector<Corner> slowDetect(const cv::Mat& picture) {
  cv::Mat scores(picture.size(), CV_16S);
  for (int y = 0; y < picture.rows; ++y) {
    for (int x = 0; x < picture.cols; ++x) {
      scores.at<std::int16_t>(y, x) = static_cast<std::int16_t>(slowScore(picture, x, y));
    }
  }
  std::vector<Corner> corners;
  std::map<std::pair<int, int>, int> strongest;
  const auto cell = [&](int x, int y) { return std::pair(cellOf(x, picture.cols), cellOf(y, picture.rows)); };
  for (int y = 1; y < picture.rows - 1; ++y) {
    for (int x = 1; x < picture.cols - 1; ++x) {
      const int score = scores.at<std::int16_t>(y, x);
      bool is_maximum = score >= 0;
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          const bool is_earlier = std::pair(dy, dx) < std::pair(0, 0);
          const int other = scores.at<std::int16_t>(y + dy, x + dx);
          is_maximum = is_maximum && (is_earlier ? other < score : other <= score);
        }
      }
      if (is_maximum) {
        corners.push_back(
            {static_cast<std::int16_t>(x), static_cast<std::int16_t>(y), static_cast<std::uint8_t>(score)});
        int& best = strongest[cell(x, y)];
        best = std::max(best, score);
      }
    }
  }
  std::erase_if(corners, [&](const Corner& corner) {
    return strongest[cell(corner.x, corner.y)] >= kThreshold && corner.score < kThreshold;
  });
  return corners;
}

/// Noise smoothed over `sigma` pixels, weaker to the right so that cells of both thresholds occur.
cv::Mat noise(cv::Size size, double sigma, std::uint64_t seed) {
  cv::RNG random(seed);
  cv::Mat picture(size, CV_8UC1);
  random.fill(picture, cv::RNG::UNIFORM, 0, 256);
  if (sigma > 0.0) {
    cv::GaussianBlur(picture, picture, cv::Size(), sigma);
    cv::normalize(picture, picture, 0, 255, cv::NORM_MINMAX);
  }
  for (int x = 0; x < picture.cols; ++x) {
    picture.col(x).convertTo(picture.col(x), CV_8U, 1.0 - 0.9 * x / picture.cols);
  }
  return picture;
}

std::vector<Corner> detect(const cv::Mat& picture) {
  FastDetector detector(kThreshold, kMinThreshold);
  std::vector<Corner> corners;
  detector.detect(picture, &corners);
  return corners;
}

class FastOnNoise : public testing::TestWithParam<std::tuple<cv::Size, double>> {};

TEST_P(FastOnNoise, FindsWhatTheSlowOracleFinds) {
  const auto& [size, sigma] = GetParam();
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const cv::Mat picture = noise(size, sigma, seed);
    EXPECT_EQ(detect(picture), slowDetect(picture));
  }
}

INSTANTIATE_TEST_SUITE_P(Pictures, FastOnNoise,
                         testing::Combine(testing::Values(cv::Size(39, 39), cv::Size(40, 71),
                                                          cv::Size(127, 64), cv::Size(230, 131)),
                                          testing::Values(0.0, 1.0, 2.0, 4.0)));

TEST(FastDetector, FindsCornersAtBothThresholds) {
  const std::vector<Corner> corners = detect(noise({230, 131}, 2.0, 1));
  const auto isStrong = [](const Corner& corner) { return corner.score >= kThreshold; };
  const auto strong = std::count_if(corners.begin(), corners.end(), isStrong);
  EXPECT_GT(strong, 10);
  EXPECT_GT(static_cast<std::ptrdiff_t>(corners.size()) - strong, 10);
}

TEST(FastDetector, LooksAtPartsOfPicturesInPlace) {
  const cv::Mat picture = noise({300, 200}, 1.0, 4);
  const cv::Mat part = picture(cv::Rect(31, 17, 133, 101));
  EXPECT_EQ(detect(part), slowDetect(part.clone()));
}

TEST(FastDetector, ReachesTheHighestScores) {
  cv::Mat picture(60, 60, CV_8UC1, cv::Scalar(0));
  picture.at<std::uint8_t>(30, 30) = 255;
  EXPECT_EQ(detect(picture), (std::vector<Corner>{{30, 30, 254}}));
}

TEST(FastDetector, FindsNothingInUniformOrTinyPictures) {
  EXPECT_TRUE(detect(cv::Mat(100, 100, CV_8UC1, cv::Scalar(0))).empty());
  EXPECT_TRUE(detect(cv::Mat(100, 100, CV_8UC1, cv::Scalar(255))).empty());
  EXPECT_TRUE(detect(noise({38, 100}, 0.0, 1)).empty());
  EXPECT_TRUE(detect(noise({1, 1}, 0.0, 1)).empty());
  EXPECT_TRUE(detect(cv::Mat(0, 0, CV_8UC1)).empty());
}

}  // namespace
}  // namespace rubble::orb
