#include "tracking/initializer.h"

#include <algorithm>

#include "orb/hamming.h"

namespace rubble::slam_mono {

namespace {

constexpr double kRadius = 100.0;         // pixels, how far a feature may go from one frame to the next
constexpr std::size_t kMostBetween = 90;  // frames
constexpr double kMaxRatio = 0.9;         // NNDR
constexpr double kMinMotion = 5.0;        // pixels, median; less cannot hold enough parallax

}  // namespace

void Initializer::begin(const std::shared_ptr<const Frame>& frame) {
  first_ = frame;
  between_.clear();
  last_pixel_.resize(frame->size());
  for (std::size_t i = 0; i < frame->size(); ++i) {
    last_pixel_[i] = frame->pixel(i);
  }
}

int Initializer::match(const Frame& frame) {
  struct Claim {
    int distance = orb::kNoDistance;
    std::uint32_t first = 0;
  };
  std::vector<Claim> claims(frame.size());
  std::vector<std::uint32_t> candidates;
  for (std::uint32_t i = 0; i < first_->size(); ++i) {
    const int octave = first_->features.octave[i];
    candidates.clear();
    frame.grid.find(frame.features, last_pixel_[i], kRadius, octave - 1, octave + 1, candidates);
    const orb::NearestTwo n =
        orb::nearestTwo(first_->features.descriptors[i], frame.features.descriptors, candidates);
    if (n.best_distance <= kStrictDistance && n.best_distance <= kMaxRatio * n.second_distance) {
      Claim& claim = claims[static_cast<std::size_t>(n.best)];
      if (n.best_distance < claim.distance) {
        claim = {n.best_distance, i};
      }
    }
  }
  std::vector<std::uint32_t> features;
  std::vector<float> turns;
  for (std::uint32_t j = 0; j < frame.size(); ++j) {
    if (claims[j].distance < orb::kNoDistance) {
      features.push_back(j);
      turns.push_back(frame.features.angle[j] - first_->features.angle[claims[j].first]);
    }
  }
  const std::vector<bool> consistent = consistentTurns(turns);
  matches_.assign(first_->size(), std::nullopt);
  int count = 0;
  for (std::size_t k = 0; k < features.size(); ++k) {
    if (consistent[k]) {
      const std::uint32_t i = claims[features[k]].first;
      matches_[i] = features[k];
      last_pixel_[i] = frame.pixel(features[k]);
      ++count;
    }
  }
  return count;
}

std::optional<NewMap> Initializer::addFrame(const std::shared_ptr<const Frame>& frame) {
  if (frame->size() < static_cast<std::size_t>(config_.min_matches)) {
    first_.reset();
    return std::nullopt;
  }
  if (!first_ || match(*frame) < config_.min_matches) {
    begin(frame);
    return std::nullopt;
  }
  const std::vector<std::shared_ptr<const Frame>> between(between_.begin(), between_.end());
  between_.push_back(frame);
  if (between_.size() > kMostBetween) {
    between_.pop_front();
  }
  std::vector<TwoViewMatch> views;
  std::vector<NewMap::Pair> pairs;
  std::vector<double> motions;
  for (std::uint32_t i = 0; i < first_->size(); ++i) {
    if (matches_[i]) {
      const int octave = std::max(first_->features.octave[i], frame->features.octave[*matches_[i]]);
      views.push_back({first_->pixel(i), frame->pixel(*matches_[i]), scales_[octave]});
      pairs.push_back({i, *matches_[i], Eigen::Vector3d::Zero()});
      motions.push_back((views.back().pixel_a - views.back().pixel_b).norm());
    }
  }
  const auto middle = motions.begin() + static_cast<std::ptrdiff_t>(motions.size() / 2);
  std::nth_element(motions.begin(), middle, motions.end());
  if (*middle < kMinMotion) {
    return std::nullopt;
  }
  TwoViewConfig config;
  config.min_points = config_.min_points;
  config.min_parallax = config_.min_parallax;
  const auto result = reconstructTwoViews(camera_, views, config);
  if (!result) {
    return std::nullopt;
  }
  NewMap map{first_, frame, result->T_b_a, {}, between};
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    if (result->points_a[k]) {
      map.pairs.push_back({pairs[k].first, pairs[k].second, *result->points_a[k]});
    }
  }
  first_.reset();
  return map;
}

}  // namespace rubble::slam_mono
