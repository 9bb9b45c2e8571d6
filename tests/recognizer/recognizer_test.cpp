#include "recognizer/recognizer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "orb/orb_extractor.h"
#include "quad.h"
#include "recognizer/trainer.h"
#include "support/error_text.h"
#include "support/temp_dir.h"
#include "synthetic_signs.h"

namespace rubble::recognizer {
namespace {

class SignRecognizer : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    cv::setNumThreads(1);
    const test::TempDir folder;
    for (const test::Sign& sign : test::makeSigns()) {
      cv::imwrite((folder.path() / (sign.name + ".png")).string(), sign.picture);
    }
    folder.write("samples.yaml", "ladder: {kind: tool, width: 0.3, height: 0.3}\n");
    vocabulary_ =
        std::make_shared<const Vocabulary>(train({folder.path()}, {.renderings = 60, .clutter = 1500}));
  }
  static void TearDownTestSuite() { vocabulary_.reset(); }

  std::vector<Detection> recognise(const cv::Mat& picture) {
    cv::Mat grey;
    cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
    return recogniser_.recognise(extractor_.extract(grey), picture);
  }

  static std::shared_ptr<const Vocabulary> vocabulary_;
  orb::OrbExtractor extractor_{orb::OrbConfig{}};
  Recognizer recogniser_{RecognizerConfig(), vocabulary_};
};

std::shared_ptr<const Vocabulary> SignRecognizer::vocabulary_;

/// The detection of a class nearest to `quad`, corner by corner; pixels.
double nearestOf(const std::vector<Detection>& detections, const std::string& name, const Quad& quad) {
  double nearest = 1e9;
  for (const Detection& detection : detections) {
    double farthest = 0.0;
    for (std::size_t i = 0; i < 4; ++i) {
      farthest = std::max(farthest, cv::norm(detection.quad[i] - quad[i]));
    }
    if (detection.class_name == name) {
      nearest = std::min(nearest, farthest);
    }
  }
  return nearest;
}

TEST_F(SignRecognizer, FindsSeveralSignsAndTheirCorners) {
  const auto signs = test::makeSigns();
  cv::Mat picture = test::makeWall(8);
  const Quad ladder = test::squareAt({130, 120}, 110, 0.3F);
  const Quad other_ladder = test::squareAt({480, 130}, 70, 2.5F);
  const Quad exit = {cv::Point2f(250, 270), {380, 290}, {370, 400}, {240, 410}};
  const Quad spark = test::squareAt({560, 380}, 44, 0.785F);
  test::paste(signs[1].picture, ladder, &picture);
  test::paste(signs[1].picture, other_ladder, &picture);
  test::paste(signs[0].picture, exit, &picture);
  test::paste(signs[2].picture, spark, &picture);
  const auto detections = recognise(picture);
  EXPECT_EQ(detections.size(), 4U);
  EXPECT_LT(nearestOf(detections, "ladder", ladder), 12.0);
  EXPECT_LT(nearestOf(detections, "ladder", other_ladder), 9.0);
  EXPECT_LT(nearestOf(detections, "exit", exit), 14.0);
  EXPECT_LT(nearestOf(detections, "spark", spark), 7.0);
  const auto tool = std::find_if(detections.begin(), detections.end(),
                                 [](const Detection& d) { return d.class_name == "ladder"; });
  ASSERT_NE(tool, detections.end());
  EXPECT_EQ(tool->kind, "tool");
  EXPECT_EQ(tool->width, 0.3);
}

TEST_F(SignRecognizer, FindsNothingOnWalls) {
  for (int seed = 20; seed < 26; ++seed) {
    EXPECT_TRUE(recognise(test::makeWall(seed)).empty()) << seed;
  }
}

TEST_F(SignRecognizer, LooksIntoTheLargerPicture) {
  cv::Mat picture;
  cv::resize(test::makeWall(9), picture, cv::Size(), 3.0, 3.0);
  const Quad quad = test::squareAt({900, 600}, 90, 0.6F);
  test::paste(test::makeSigns()[2].picture, quad, &picture);
  cv::Mat grey;
  cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
  cv::resize(grey, grey, cv::Size(), 1.0 / 3.0, 1.0 / 3.0, cv::INTER_AREA);
  const auto detections = recogniser_.recognise(extractor_.extract(grey), picture);
  EXPECT_LT(nearestOf(detections, "spark", rescaled(quad, 1.0F / 3.0F)), 5.0);
}

TEST_F(SignRecognizer, IsDeterministic) {
  cv::Mat picture = test::makeWall(10);
  test::paste(test::makeSigns()[0].picture, test::squareAt({300, 200}, 100, 0.2F), &picture);
  const auto first = recognise(picture);
  const auto second = recognise(picture);
  ASSERT_EQ(first.size(), second.size());
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].score, second[i].score);
    EXPECT_EQ(first[i].quad, second[i].quad);
  }
}

TEST_F(SignRecognizer, ACandidateBudgetOfNoneFindsNothing) {
  cv::Mat picture = test::makeWall(10);
  test::paste(test::makeSigns()[0].picture, test::squareAt({300, 200}, 100, 0.2F), &picture);
  RecognizerConfig config;
  config.candidates = 0;
  recogniser_ = Recognizer(config, vocabulary_);
  EXPECT_TRUE(recognise(picture).empty());
}

TEST_F(SignRecognizer, OtherPixelsAreAnError) {
  orb::Features features;
  features.width = 64;
  features.height = 64;
  const cv::Mat picture(64, 64, CV_32F);
  EXPECT_NE(test::errorOf([&] { recogniser_.recognise(features, picture); }).find("8-bit"),
            std::string::npos);
}

}  // namespace
}  // namespace rubble::recognizer
