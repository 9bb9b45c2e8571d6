#include <gtest/gtest.h>

#include <memory>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "orb/orb_extractor.h"
#include "quad.h"
#include "recognizer/recognizer.h"
#include "recognizer/trainer.h"
#include "support/temp_dir.h"
#include "synthetic_signs.h"
#include "vocabulary_data.h"

namespace rubble::recognizer {
namespace {

/// Something like a doll that lies on its back, seen from its side: BGRA, its clothes by the seed.
cv::Mat makeDoll(int seed) {
  cv::RNG random(static_cast<std::uint64_t>(seed) + 1);
  cv::Mat doll = cv::Mat::zeros(90, 200, CV_8UC4);
  const auto colour = [&] {
    return cv::Scalar(random.uniform(20, 235), random.uniform(20, 235), random.uniform(20, 235), 255);
  };
  const cv::Scalar trousers = colour();
  const cv::Scalar shirt = colour();
  const int lift = random.uniform(0, 12);
  cv::line(doll, {120, 60}, {178, 66 - lift}, trousers, 22, cv::LINE_8);
  cv::ellipse(doll, {95, 58}, {36, 22}, 0.0, 0.0, 360.0, shirt, cv::FILLED);
  cv::line(doll, {80, 55}, {110, 30 + lift}, shirt, 13, cv::LINE_8);
  cv::circle(doll, {112, 28 + lift}, 8, {140, 170, 220, 255}, cv::FILLED);
  cv::circle(doll, {40, 52}, 25, {140, 170, 220, 255}, cv::FILLED);
  cv::ellipse(doll, {36, 52}, {27, 27}, 0.0, 90.0, 270.0, {30, 40, 60, 255}, cv::FILLED);
  return doll;
}

void put(const cv::Mat& doll, cv::Point place, double scale, cv::Mat* picture) {
  cv::Mat small;
  cv::resize(doll, small, cv::Size(), scale, scale, cv::INTER_AREA);
  cv::Mat bgr;
  cv::cvtColor(small, bgr, cv::COLOR_BGRA2BGR);
  cv::Mat alpha;
  cv::extractChannel(small, alpha, 3);
  bgr.copyTo((*picture)(cv::Rect(place, small.size())), alpha > 127);
}

class DollRecognizer : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    cv::setNumThreads(1);
    const test::TempDir folder;
    cv::imwrite((folder.path() / "spark.png").string(), test::makeSigns()[2].picture);
    std::filesystem::create_directory(folder.path() / "doll");
    for (int i = 0; i < 12; ++i) {
      cv::imwrite((folder.path() / "doll" / (std::to_string(i) + ".png")).string(), makeDoll(i));
    }
    std::filesystem::create_directory(folder.path() / "background");
    for (int i = 0; i < 6; ++i) {
      cv::imwrite((folder.path() / "background" / (std::to_string(i) + ".jpg")).string(),
                  test::makeWall(100 + i));
    }
    folder.write("samples.yaml", "doll: {kind: victim}\n");
    vocabulary_ = std::make_shared<const Vocabulary>(
        train({folder.path()}, {.renderings = 30, .clutter = 900, .solids = 700}));
  }
  static void TearDownTestSuite() { vocabulary_.reset(); }

  std::vector<Detection> recognise(const cv::Mat& picture, bool with_solids = true) {
    cv::Mat grey;
    cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
    return recogniser_.recognise(extractor_.extract(grey), picture, with_solids);
  }

  static std::shared_ptr<const Vocabulary> vocabulary_;
  orb::OrbExtractor extractor_{orb::OrbConfig{}};
  // So few samples and renderings do not make it as sure as the arena's.
  Recognizer recogniser_{{.solid_score = 0.4}, vocabulary_};
};

std::shared_ptr<const Vocabulary> DollRecognizer::vocabulary_;

TEST_F(DollRecognizer, FindsADollInOtherClothesFromNearAndFar) {
  for (const double scale : {0.4, 0.6}) {
    cv::Mat picture = test::makeWall(9);
    put(makeDoll(40), {220, 200}, scale, &picture);
    const auto detections = recognise(picture);
    ASSERT_EQ(detections.size(), 1U) << scale;
    EXPECT_EQ(detections[0].class_name, "doll");
    EXPECT_EQ(detections[0].kind, "victim");
    const auto far = [&](double x, double y) {
      return static_cast<float>(scale * x) + static_cast<float>(y);
    };
    const cv::Rect2f truth(far(9, 220), far(20, 200), far(180, 0), far(60, 0));
    EXPECT_GT(overlap(boundsOf(detections[0].quad), truth), 0.4F) << scale;
    EXPECT_TRUE(recognise(picture, false).empty());
  }
}

TEST_F(DollRecognizer, FindsNothingOnWalls) {
  for (int seed = 20; seed < 26; ++seed) {
    EXPECT_TRUE(recognise(test::makeWall(seed)).empty()) << seed;
  }
}

TEST_F(DollRecognizer, LabelsAreFoundAsWithoutDolls) {
  cv::Mat picture = test::makeWall(9);
  test::paste(test::makeSigns()[2].picture, test::squareAt({520.0F, 110.0F}, 110.0F, 0.1F), &picture);
  put(makeDoll(40), {220, 200}, 0.6, &picture);
  const auto labels = recognise(picture, false);
  ASSERT_EQ(labels.size(), 1U);
  const auto all = recognise(picture);
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[0].class_name, "spark");
  EXPECT_EQ(all[0].score, labels[0].score);
  EXPECT_EQ(all[0].quad, labels[0].quad);
  EXPECT_EQ(all[1].class_name, "doll");
}

TEST_F(DollRecognizer, WhatALabelExplainsIsNoDoll) {
  // Everything is taken for a doll.
  Recognizer gullible{{.solid_score = 0.0}, vocabulary_};
  cv::Mat picture = test::makeWall(12);
  const auto corners = test::squareAt({300.0F, 240.0F}, 150.0F, 0.0F);
  test::paste(test::makeSigns()[2].picture, corners, &picture);
  cv::Mat grey;
  cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
  const cv::Rect2f sign = boundsOf(corners);
  for (const Detection& detection : gullible.recognise(extractor_.extract(grey), picture)) {
    if (detection.kind == "victim") {
      const cv::Rect2f box = boundsOf(detection.quad);
      EXPECT_LT((box & sign).area(), 0.3F * box.area());
    }
  }
}

TEST_F(DollRecognizer, DollsAreNoViewsOfFlatThings) {
  EXPECT_EQ(vocabulary_->viewCount(), 1U);
  ASSERT_FALSE(vocabulary_->data().solids.empty());
  const auto bytes = vocabulary_->serialised();
  EXPECT_EQ(Vocabulary::parse(bytes, "dolls").serialised(), bytes);
}

}  // namespace
}  // namespace rubble::recognizer
