#include "orb/orb_extractor.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "orb/hamming.h"
#include "support/error_text.h"

namespace rubble::orb {
namespace {

using testing::HasSubstr;

/// Overlapping rectangles and discs of all sizes, smoothed as by a lens, with the camera's noise.
cv::Mat texture(cv::Size size, std::uint64_t seed) {
  cv::RNG random(seed);
  cv::Mat picture(size, CV_8UC1, cv::Scalar(128));
  for (int i = 0; i < size.area() / 400; ++i) {
    const cv::Point at(random.uniform(0, size.width), random.uniform(0, size.height));
    const cv::Scalar grey(random.uniform(20, 235));
    const int extent = random.uniform(3, 50);
    if (i % 2 == 0) {
      cv::rectangle(picture, cv::Rect(at, cv::Size(extent, random.uniform(3, 50))), grey, cv::FILLED);
    } else {
      cv::circle(picture, at, extent / 2, grey, cv::FILLED);
    }
  }
  cv::GaussianBlur(picture, picture, cv::Size(), 1.0);
  return picture;
}

cv::Mat withNoise(const cv::Mat& picture, double sigma, std::uint64_t seed) {
  cv::RNG random(seed);
  cv::Mat noise(picture.size(), CV_16SC1);
  random.fill(noise, cv::RNG::NORMAL, 0.0, sigma);
  cv::Mat noisy;
  cv::add(picture, noise, noisy, cv::noArray(), CV_8U);
  return noisy;
}

cv::Point2d position(const Features& features, std::size_t i) {
  return {static_cast<double>(features.x[i]), static_cast<double>(features.y[i])};
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

bool areEqual(const Features& a, const Features& b) {
  return a.x == b.x && a.y == b.y && a.angle == b.angle && a.octave == b.octave &&
         a.descriptors == b.descriptors;
}

TEST(OrbExtractor, FindsAsManyAsWantedInProportionToTheArea) {
  OrbExtractor extractor({});
  const Features vga = extractor.extract(texture({640, 480}, 1));
  EXPECT_EQ(vga.size(), 1000U);
  EXPECT_EQ(vga.width, 640);
  EXPECT_EQ(vga.height, 480);
  EXPECT_EQ(extractor.extract(texture({320, 240}, 1)).size(), 250U);
  EXPECT_EQ(extractor.extract(texture({752, 480}, 1)).size(), 1175U);
  EXPECT_EQ(extractor.extract(texture({1280, 720}, 1)).size(), static_cast<std::size_t>(kMostFeatures));
}

TEST(OrbExtractor, GivesFewerFeaturesToCoarserLevels) {
  const Features features = OrbExtractor({}).extract(texture({640, 480}, 2));
  std::vector<int> counts(8, 0);
  for (const std::uint8_t octave : features.octave) {
    ++counts.at(octave);
  }
  for (std::size_t i = 1; i < counts.size(); ++i) {
    EXPECT_NEAR(counts[i], counts[i - 1] / 1.2, 3.0);
  }
}

TEST(OrbExtractor, SpreadsFeaturesEvenly) {
  // Strong contrast in one half only.
  cv::Mat picture = texture({640, 480}, 3);
  cv::Mat left = picture.colRange(0, 320);
  left.convertTo(left, CV_8U, 0.25, 96);
  const Features features = OrbExtractor({}).extract(picture);
  constexpr int kColumns = 8;
  constexpr int kRows = 6;
  std::vector<int> counts(kColumns * kRows, 0);
  for (std::size_t i = 0; i < features.size(); ++i) {
    const int column = static_cast<int>(features.x[i]) * kColumns / 640;
    const int row = static_cast<int>(features.y[i]) * kRows / 480;
    const int cell = row * kColumns + column;
    ++counts.at(static_cast<std::size_t>(cell));
  }
  const auto [fewest, most] = std::minmax_element(counts.begin(), counts.end());
  EXPECT_GE(*fewest, 4);
  EXPECT_LE(*most, 60);
}

TEST(OrbExtractor, IsDeterministicAndKeepsNoState) {
  const cv::Mat one = withNoise(texture({640, 480}, 4), 3.0, 1);
  const cv::Mat other = texture({400, 300}, 5);
  OrbExtractor extractor({});
  const Features first = extractor.extract(one);
  extractor.extract(other);
  EXPECT_TRUE(areEqual(first, extractor.extract(one)));
  EXPECT_TRUE(areEqual(first, OrbExtractor({}).extract(one.clone())));
  cv::Mat wide(600, 800, CV_8UC1, cv::Scalar(77));
  one.copyTo(wide(cv::Rect(50, 40, 640, 480)));
  EXPECT_TRUE(areEqual(first, extractor.extract(wide(cv::Rect(50, 40, 640, 480)))));
}

struct Warp {
  double degrees;
  double scale;
  double least_right;  ///< share of matches
  double most_error;   ///< pixels, median
};

class OrbUnderWarp : public testing::TestWithParam<Warp> {};

TEST_P(OrbUnderWarp, MatchesAndLocates) {
  const Warp& warp = GetParam();
  const cv::Mat picture = texture({640, 480}, 6);
  const cv::Matx23d affine = cv::getRotationMatrix2D({319.5F, 239.5F}, warp.degrees, warp.scale);
  cv::Mat warped;
  cv::warpAffine(picture, warped, affine, picture.size(), cv::INTER_CUBIC, cv::BORDER_REFLECT_101);
  OrbExtractor extractor({});
  const Features a = extractor.extract(withNoise(picture, 3.0, 1));
  const Features b = extractor.extract(withNoise(warped, 3.0, 2));
  std::vector<NearestTwo> nearest(a.size());
  nearestTwoOfAll(a.descriptors, b.descriptors, nearest);

  std::vector<double> errors;
  std::vector<double> turns;
  std::size_t matches = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const cv::Point2d from = position(a, i);
    const cv::Vec2d to = affine * cv::Vec3d(from.x, from.y, 1.0);
    const bool is_inside = cv::Rect2d(40, 40, 560, 400).contains({to[0], to[1]});
    if (!is_inside || nearest[i].best_distance > 60 ||
        10 * nearest[i].best_distance > 8 * nearest[i].second_distance) {
      continue;
    }
    ++matches;
    const auto j = static_cast<std::size_t>(nearest[i].best);
    const double error = cv::norm(position(b, j) - cv::Point2d(to[0], to[1])) / std::pow(1.2, b.octave[j]);
    if (error < 3.0) {
      errors.push_back(error);
      // The picture turns counter-clockwise, angles count clockwise.
      const double turn = static_cast<double>(b.angle[j] - a.angle[i]);
      turns.push_back(
          std::abs(std::remainder(turn + warp.degrees * std::numbers::pi / 180.0, 2.0 * std::numbers::pi)));
    }
  }
  ASSERT_GT(errors.size(), 50U);
  const double right = static_cast<double>(errors.size()) / static_cast<double>(matches);
  EXPECT_GT(right, warp.least_right);
  EXPECT_LT(median(errors), warp.most_error) << "pixels of the feature's level";
  EXPECT_LT(median(turns), 0.1);
}

INSTANTIATE_TEST_SUITE_P(Known, OrbUnderWarp,
                         testing::Values(Warp{0.0, 1.0, 0.95, 0.1}, Warp{30.0, 1.0, 0.9, 0.35},
                                         Warp{90.0, 1.0, 0.9, 0.35}, Warp{0.0, 1.2, 0.9, 0.35},
                                         Warp{0.0, 1.5, 0.9, 0.35}, Warp{30.0, 2.0, 0.9, 0.45}));

/// Spots between the pixels are found where they are, on every level: the levels' centres fit together.
TEST(OrbExtractor, LocatesSpotsWithoutBiasOnAllLevels) {
  cv::Mat picture(480, 640, CV_8UC1, cv::Scalar(60));
  std::vector<cv::Point2d> spots(48);
  for (int i = 0; cv::Point2d & spot : spots) {
    spot = {90.0 + 65.3 * (i % 8), 90.0 + 60.7 * std::floor(i / 8.0)};
    ++i;
  }
  for (int y = 0; y < picture.rows; ++y) {
    for (int x = 0; x < picture.cols; ++x) {
      double grey = 60.0;
      for (const cv::Point2d& spot : spots) {
        const cv::Point2d away = cv::Point2d(x, y) - spot;
        grey += 150.0 * std::exp(-away.dot(away) / (2.0 * 2.5 * 2.5));
      }
      picture.at<std::uint8_t>(y, x) = cv::saturate_cast<std::uint8_t>(grey);
    }
  }
  const Features features = OrbExtractor({}).extract(picture);
  std::vector<cv::Point2d> sums(8);
  std::vector<int> counts(8, 0);
  for (std::size_t i = 0; i < features.size(); ++i) {
    for (const cv::Point2d& spot : spots) {
      const cv::Point2d error = position(features, i) - spot;
      if (cv::norm(error) < 10.0) {
        EXPECT_LT(cv::norm(error), 1.0 * std::pow(1.2, features.octave[i]));
        sums.at(features.octave[i]) += error;
        ++counts.at(features.octave[i]);
      }
    }
  }
  for (std::size_t octave = 0; octave < 6; ++octave) {
    EXPECT_EQ(counts[octave], 48) << octave;
    EXPECT_LT(cv::norm(sums[octave] / counts[octave]), 0.1) << octave;
  }
}

TEST(OrbExtractor, TakesPicturesWithoutAndWithTooMuchTexture) {
  OrbExtractor extractor({});
  EXPECT_EQ(extractor.extract(cv::Mat(480, 640, CV_8UC1, cv::Scalar(0))).size(), 0U);
  EXPECT_EQ(extractor.extract(cv::Mat(480, 640, CV_8UC1, cv::Scalar(255))).size(), 0U);
  cv::Mat noise(480, 640, CV_8UC1);
  cv::RNG random(8);
  random.fill(noise, cv::RNG::UNIFORM, 0, 256);
  EXPECT_EQ(extractor.extract(noise).size(), 1000U);
  EXPECT_LE(extractor.extract(noise(cv::Rect(0, 0, 64, 64))).size(), 14U);
  EXPECT_LE(extractor.extract(noise(cv::Rect(0, 0, 640, 64))).size(), 134U);
  EXPECT_LE(extractor.extract(noise(cv::Rect(0, 0, 64, 480))).size(), 100U);
}

TEST(OrbExtractor, FindsFaintTextureAgain) {
  // A plain wall: hardly anything there differs by the lower threshold of 7.
  cv::Mat faint;
  texture({640, 480}, 9).convertTo(faint, CV_8UC1, 0.05, 120.0);
  OrbExtractor extractor({});
  const Features first = extractor.extract(withNoise(faint, 0.5, 10));
  const Features second = extractor.extract(withNoise(faint, 0.5, 11));
  EXPECT_GT(first.size(), 500U);
  std::size_t found = 0;
  for (std::size_t i = 0; i < first.size(); ++i) {
    for (std::size_t j = 0; j < second.size(); ++j) {
      if (first.octave[i] == second.octave[j] && cv::norm(position(first, i) - position(second, j)) < 4.0 &&
          hammingDistance(first.descriptors[i], second.descriptors[j]) <= 50) {
        ++found;
        break;
      }
    }
  }
  EXPECT_GT(found, first.size() / 2);
}

TEST(OrbExtractor, RefusesOtherPictures) {
  OrbExtractor extractor({});
  const auto errorFor = [&](const cv::Mat& picture) {
    return test::errorOf([&] { extractor.extract(picture); });
  };
  EXPECT_THAT(errorFor(cv::Mat()), HasSubstr("0 x 0"));
  EXPECT_THAT(errorFor(cv::Mat(480, 640, CV_8UC3)), HasSubstr("8-bit grey"));
  EXPECT_THAT(errorFor(cv::Mat(480, 640, CV_16UC1)), HasSubstr("8-bit grey"));
  EXPECT_THAT(errorFor(cv::Mat(63, 640, CV_8UC1)), HasSubstr("640 x 63"));
  EXPECT_THAT(errorFor(cv::Mat(640, 63, CV_8UC1)), HasSubstr("63 x 640"));
}

TEST(OrbExtractor, RefusesImpossibleConfigurations) {
  const auto errorFor = [](const OrbConfig& config) {
    return test::errorOf([&] { OrbExtractor extractor(config); });
  };
  EXPECT_THAT(errorFor({.features = 0}), HasSubstr("features"));
  EXPECT_THAT(errorFor({.scale_factor = 1.0}), HasSubstr("scale_factor"));
  EXPECT_THAT(errorFor({.levels = 0}), HasSubstr("levels"));
  EXPECT_THAT(errorFor({.threshold = 5}), HasSubstr("threshold"));
  EXPECT_THAT(errorFor({.min_threshold = 0}), HasSubstr("threshold"));
}

}  // namespace
}  // namespace rubble::orb
