#include "hypotheses.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <random>

#include "orb/orb_extractor.h"
#include "synthetic_signs.h"

namespace rubble::recognizer {
namespace {

/// Words of two views and features that see them; feature i matches word i.
struct Scene {
  std::vector<orb::Descriptor> descriptors;
  std::vector<WordPlace> places;
  orb::Features features;
  std::vector<WordMatch> matches;

  /// A view whose outline lies at `quad`.
  void add(std::uint32_t view, const Quad& quad, int count, std::mt19937* random) {
    std::uniform_real_distribution<float> unit(0.05F, 0.95F);
    const Quad square = {cv::Point2f(0, 0), {1, 0}, {1, 1}, {0, 1}};
    const cv::Matx33d homography(cv::getPerspectiveTransform(square.data(), quad.data()));
    const cv::Point2f top = quad[1] - quad[0];
    const float side = std::hypot(top.x, top.y);
    for (int i = 0; i < count; ++i) {
      WordPlace place{.object_class = view, .view = view, .x = unit(*random), .y = unit(*random)};
      place.angle = 6.0F * unit(*random);
      place.size = 1.0F / side;
      const cv::Vec3d p = homography * cv::Vec3d(place.x, place.y, 1.0);
      features.x.push_back(static_cast<float>(p[0] / p[2]));
      features.y.push_back(static_cast<float>(p[1] / p[2]));
      features.angle.push_back(place.angle + std::atan2(top.y, top.x));
      features.octave.push_back(0);
      matches.push_back({.word = static_cast<int>(places.size()), .distance = 20, .second_distance = 90});
      places.push_back(place);
      descriptors.push_back({places.size(), 0, 0, 0});
    }
    features.descriptors.resize(features.x.size());
  }

  std::vector<Hypothesis> find() const {
    // One centre, so that the words keep their order.
    const WordIndex words(descriptors, places, {descriptors.front()},
                          {0, static_cast<std::uint32_t>(descriptors.size())});
    return findHypotheses(features, matches, words, RecognizerConfig());
  }
};

TEST(Hypotheses, SeveralObjectsAndSeveralOfOneKind) {
  std::mt19937 random(3);
  const std::vector<Quad> truths = {test::squareAt({120, 100}, 80, 0.3F),
                                    test::squareAt({400, 120}, 120, 1.2F),
                                    test::squareAt({300, 330}, 60, 3.0F)};
  Scene scene;
  scene.add(0, truths[0], 20, &random);
  scene.add(0, truths[1], 15, &random);
  scene.add(1, truths[2], 10, &random);
  const auto hypotheses = scene.find();
  ASSERT_EQ(hypotheses.size(), 3U);
  for (std::size_t i = 0; i < truths.size(); ++i) {
    for (std::size_t corner = 0; corner < 4; ++corner) {
      EXPECT_LT(cv::norm(hypotheses[i].quad[corner] - truths[i][corner]), 0.5);
    }
  }
  EXPECT_EQ(hypotheses[0].matches, 20);
  EXPECT_EQ(hypotheses[2].view, 1U);
}

TEST(Hypotheses, OutliersAndTooFewMatchesMakeNone) {
  std::mt19937 random(4);
  Scene scene;
  scene.add(0, test::squareAt({120, 100}, 80, 0.3F), 4, &random);
  std::uniform_real_distribution<float> anywhere(0.0F, 480.0F);
  scene.add(1, test::squareAt({300, 300}, 100, 0.0F), 30, &random);
  for (std::size_t i = 4; i < scene.matches.size(); ++i) {
    scene.features.x[i] = anywhere(random);
    scene.features.y[i] = anywhere(random);
    scene.features.angle[i] = 0.01F * anywhere(random);
  }
  EXPECT_TRUE(scene.find().empty());
}

TEST(Hypotheses, MirroredPlacesAreImplausible) {
  std::mt19937 random(5);
  const Quad quad = test::squareAt({200, 200}, 100, 0.0F);
  Scene scene;
  scene.add(0, {quad[1], quad[0], quad[3], quad[2]}, 30, &random);
  EXPECT_TRUE(scene.find().empty());
}

TEST(Hypotheses, AmbiguousMatchesDoNotVote) {
  std::mt19937 random(6);
  Scene scene;
  scene.add(0, test::squareAt({200, 200}, 100, 0.5F), 30, &random);
  for (WordMatch& match : scene.matches) {
    match.second_distance = 22;
  }
  EXPECT_TRUE(scene.find().empty());
}

}  // namespace
}  // namespace rubble::recognizer
