#include "scene/materials.h"

#include <gtest/gtest.h>

#include <array>
#include <opencv2/imgproc.hpp>
#include <thread>

namespace rubble::arena_sim {
namespace {

constexpr float kPixel = 0.004F;
const cv::Size2f kPanel(0.8F, 0.6F);

constexpr std::array kMaterials{Material::kOsb,      Material::kPlywood, Material::kPlanks,
                                Material::kConcrete, Material::kPaint,   Material::kCardboard,
                                Material::kMetal,    Material::kRubber,  Material::kCloth,
                                Material::kSkin,     Material::kCarpet,  Material::kBricks};

bool areEqual(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0.0;
}

struct Grey {
  double mean = 0.0;
  double sigma = 0.0;
};

Grey greyOf(Material material, std::uint64_t seed) {
  cv::Mat green;
  cv::extractChannel(paintMaterial(material, seed, {1.2F, 1.0F}, kPixel), green, 1);
  cv::Scalar mean;
  cv::Scalar sigma;
  cv::meanStdDev(green, mean, sigma);
  return {mean[0], sigma[0]};
}

TEST(Materials, SameSeedSamePictureOtherSeedOther) {
  for (const Material material : kMaterials) {
    SCOPED_TRACE(static_cast<int>(material));
    const cv::Mat picture = paintMaterial(material, 3, kPanel, kPixel);
    EXPECT_EQ(picture.type(), CV_8UC3);
    EXPECT_EQ(picture.size(), cv::Size(200, 150));
    EXPECT_TRUE(areEqual(picture, paintMaterial(material, 3, kPanel, kPixel)));
    EXPECT_FALSE(areEqual(picture, paintMaterial(material, 4, kPanel, kPixel)));
  }
}

TEST(Materials, ThreadsAndTheGlobalGeneratorDoNotMatter) {
  const std::uint64_t state = cv::theRNG().state;
  std::array<cv::Mat, kMaterials.size()> alone;
  std::array<cv::Mat, kMaterials.size()> together;
  for (std::size_t i = 0; i < kMaterials.size(); ++i) {
    alone[i] = paintMaterial(kMaterials[i], i, {0.4F, 0.4F}, kPixel);
  }
  const auto paintSome = [&](std::size_t first) {
    for (std::size_t i = first; i < kMaterials.size(); i += 2) {
      together[i] = paintMaterial(kMaterials[i], i, {0.4F, 0.4F}, kPixel);
    }
  };
  std::thread other(paintSome, 0);
  paintSome(1);
  other.join();
  for (std::size_t i = 0; i < kMaterials.size(); ++i) {
    EXPECT_TRUE(areEqual(alone[i], together[i])) << i;
  }
  EXPECT_EQ(cv::theRNG().state, state);
}

TEST(Materials, ContrastIsThatOfTheRealThing) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Grey osb = greyOf(Material::kOsb, seed);
    EXPECT_GT(osb.sigma, 12.0);
    EXPECT_LT(osb.sigma, 32.0);
    EXPECT_LT(greyOf(Material::kPaint, seed).sigma, 5.0);
    EXPECT_GT(greyOf(Material::kConcrete, seed).sigma, 8.0);
    EXPECT_GT(greyOf(Material::kBricks, seed).sigma, 12.0);
    EXPECT_LT(greyOf(Material::kRubber, seed).mean, 70.0);
  }
}

/// Correlation of two equal parts of a picture.
double correlation(const cv::Mat& a, const cv::Mat& b) {
  cv::Scalar mean_a, mean_b, sigma_a, sigma_b;
  cv::meanStdDev(a, mean_a, sigma_a);
  cv::meanStdDev(b, mean_b, sigma_b);
  cv::Mat product;
  cv::multiply(a - mean_a, b - mean_b, product);
  return cv::mean(product)[0] / (sigma_a[0] * sigma_b[0]);
}

TEST(Materials, NothingRepeatsAlongAWall) {
  for (const Material material : {Material::kOsb, Material::kConcrete}) {
    cv::Mat detail;
    cv::extractChannel(paintMaterial(material, 8, {4.0F, 0.5F}, 0.005F), detail, 1);
    detail.convertTo(detail, CV_32F);
    // Without the dirt and light of larger areas.
    cv::Mat blurred;
    cv::GaussianBlur(detail, blurred, {}, 3.0);
    detail -= blurred;
    constexpr int kPart = 200;
    const cv::Mat first = detail.colRange(0, kPart);
    EXPECT_GT(correlation(first, first), 0.99);
    for (int x = 20; x + kPart <= detail.cols; ++x) {
      ASSERT_LT(correlation(first, detail.colRange(x, x + kPart)), 0.15) << x;
    }
  }
}

TEST(Materials, TinyChartsHaveATexel) {
  for (const Material material : kMaterials) {
    EXPECT_EQ(paintMaterial(material, 1, {0.001F, 0.02F}, 0.004F).size(), cv::Size(1, 5));
  }
}

TEST(Materials, ReflectivityIsAShareAndRubberIsDarkest) {
  for (const Material material : kMaterials) {
    EXPECT_GT(reflectivityAt905nm(material), 0.0);
    EXPECT_LT(reflectivityAt905nm(material), 1.0);
    EXPECT_GE(reflectivityAt905nm(material), reflectivityAt905nm(Material::kRubber));
  }
}

}  // namespace
}  // namespace rubble::arena_sim
