#include "hypotheses.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <opencv2/calib3d.hpp>
#include <optional>

#include "orb/orb_extractor.h"

namespace rubble::recognizer {

namespace {

// Votes that tell the same.
constexpr float kPlace = 0.3F;  // of the side, between centres
constexpr float kScale = 1.7F;
constexpr float kTurn = 0.6F;  // rad
constexpr double kLongestRatio = 3.3;

/// Where a match sees the sample: a similarity.
struct Vote {
  cv::Point2f place;  // in the unit square
  cv::Point2f pixel;
  cv::Point2f centre;  // pixels
  float side = 0;      // pixels
  float turn = 0;      // rad
};

Vote voteOf(const orb::Features& features, std::size_t i, const WordPlace& word) {
  static const auto kScaleFactor = static_cast<float>(orb::OrbConfig{}.scale_factor);
  Vote vote;
  vote.place = {word.x, word.y};
  vote.pixel = {features.x[i], features.y[i]};
  vote.side = std::pow(kScaleFactor, static_cast<float>(features.octave[i])) / word.size;
  vote.turn = features.angle[i] - word.angle;
  const cv::Point2f offset = (cv::Point2f(0.5F, 0.5F) - vote.place) * vote.side;
  const float c = std::cos(vote.turn);
  const float s = std::sin(vote.turn);
  vote.centre = vote.pixel + cv::Point2f(c * offset.x - s * offset.y, s * offset.x + c * offset.y);
  return vote;
}

bool tellTheSame(const Vote& a, const Vote& b) {
  const float ratio = a.side / b.side;
  return ratio < kScale && ratio > 1.0F / kScale &&
         cv::norm(a.centre - b.centre) < static_cast<double>(kPlace * a.side) &&
         std::abs(std::remainder(a.turn - b.turn, 2.0F * std::numbers::pi_v<float>)) < kTurn;
}

/// Splits off the votes that tell the same as the one that most others agree with.
std::vector<Vote> splitLargestGroup(std::vector<Vote>* votes) {
  std::size_t most = 0;
  const Vote* seed = nullptr;
  for (const Vote& vote : *votes) {
    const auto agreeing = static_cast<std::size_t>(std::count_if(
        votes->begin(), votes->end(), [&](const Vote& other) { return tellTheSame(vote, other); }));
    if (agreeing > most) {
      most = agreeing;
      seed = &vote;
    }
  }
  std::vector<Vote> group;
  if (seed != nullptr) {
    const Vote centre = *seed;
    const auto rest = std::stable_partition(votes->begin(), votes->end(),
                                            [&](const Vote& vote) { return !tellTheSame(centre, vote); });
    group.assign(rest, votes->end());
    votes->erase(rest, votes->end());
  }
  return group;
}

std::optional<Hypothesis> verify(const std::vector<Vote>& group, const RecognizerConfig& config) {
  std::vector<cv::Point2f> places;
  std::vector<cv::Point2f> pixels;
  for (const Vote& vote : group) {
    places.push_back(vote.place);
    pixels.push_back(vote.pixel);
  }
  std::vector<std::uint8_t> inliers;
  const cv::Mat homography =
      cv::findHomography(places, pixels, cv::RANSAC, config.reprojection, inliers, 500);
  const auto count = static_cast<int>(std::count(inliers.begin(), inliers.end(), 1));
  if (homography.empty() || count < config.matches) {
    return std::nullopt;
  }
  const std::vector<cv::Point2f> unit = {{0.0F, 0.0F}, {1.0F, 0.0F}, {1.0F, 1.0F}, {0.0F, 1.0F}};
  std::vector<cv::Point2f> corners;
  cv::perspectiveTransform(unit, corners, homography);
  const Quad quad = {corners[0], corners[1], corners[2], corners[3]};
  const double side = group.front().side;
  const double area = areaOf(quad);
  if (!isPlausible(quad, kLongestRatio) || area > 4.0 * side * side || area < 0.25 * side * side) {
    return std::nullopt;
  }
  return Hypothesis{quad, 0, count};
}

}  // namespace

std::vector<Hypothesis> findHypotheses(const orb::Features& features, std::span<const WordMatch> matches,
                                       const WordIndex& words, const RecognizerConfig& config) {
  std::map<std::uint32_t, std::vector<Vote>> votes;  // by view
  for (std::size_t i = 0; i < features.size(); ++i) {
    const WordMatch& match = matches[i];
    if (match.word >= 0 && match.distance < config.ratio * match.second_distance) {
      const WordPlace& place = words.places()[static_cast<std::size_t>(match.word)];
      votes[place.view].push_back(voteOf(features, i, place));
    }
  }
  std::vector<Hypothesis> hypotheses;
  for (auto& [view, of_view] : votes) {
    while (of_view.size() >= static_cast<std::size_t>(config.matches)) {
      const std::vector<Vote> group = splitLargestGroup(&of_view);
      if (group.size() < static_cast<std::size_t>(config.matches)) {
        break;
      }
      if (auto hypothesis = verify(group, config)) {
        hypothesis->view = view;
        hypotheses.push_back(*hypothesis);
      }
    }
  }
  std::stable_sort(hypotheses.begin(), hypotheses.end(),
                   [](const Hypothesis& a, const Hypothesis& b) { return a.matches > b.matches; });
  return hypotheses;
}

}  // namespace rubble::recognizer
