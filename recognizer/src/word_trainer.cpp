#include "word_trainer.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "majority.h"
#include "orb/hamming.h"
#include "orb/orb_extractor.h"

namespace rubble::recognizer {

namespace {

constexpr std::array kSides = {48, 64, 90, 128, 180, 256};  // pixels
constexpr std::array kDirections = {0.0, 0.5, 1.0, 1.5};    // of the tilt, in half turns
constexpr double kTilt = 0.6;                               // rad
constexpr double kFeatures = 200.0;                         // wanted per rendering
constexpr std::size_t kWordsPerView = 400;
// Of features that are one word.
constexpr float kPlace = 0.025F;  // of the side
constexpr float kTurn = 0.4F;     // rad
constexpr float kSizes = 1.5F;
constexpr int kDistance = 50;

struct Cluster {
  orb::Descriptor first;
  WordPlace place;
  Majority majority;
};

float turnBetween(float a, float b) {
  return std::abs(std::remainder(a - b, 2.0F * std::numbers::pi_v<float>));
}

bool isSameWord(const Cluster& cluster, const orb::Descriptor& descriptor, const WordPlace& place) {
  const float ratio = cluster.place.size / place.size;
  return std::abs(cluster.place.x - place.x) < kPlace && std::abs(cluster.place.y - place.y) < kPlace &&
         ratio < kSizes && ratio > 1.0F / kSizes && turnBetween(cluster.place.angle, place.angle) < kTurn &&
         orb::hammingDistance(cluster.first, descriptor) <= kDistance;
}

class ViewWords {
 public:
  ViewWords(std::uint32_t object_class, std::uint32_t view) : object_class_(object_class), view_(view) {}

  void add(const orb::Features& features, const View& view, int side, double scale_factor) {
    const cv::Matx33d inverse = view.homography.inv();
    for (std::size_t i = 0; i < features.size(); ++i) {
      const cv::Vec3d p = inverse * cv::Vec3d(features.x[i], features.y[i], 1.0);
      const double x = p[0] / p[2];
      const double y = p[1] / p[2];
      if (std::min(x, y) < 0.0 || std::max(x, y) > 1.0) {
        continue;
      }
      addFeature(features.descriptors[i],
                 {.object_class = object_class_,
                  .view = view_,
                  .x = static_cast<float>(x),
                  .y = static_cast<float>(y),
                  .angle = features.angle[i],
                  .size = static_cast<float>(std::pow(scale_factor, features.octave[i]) / side)});
    }
  }

  void moveMostSeen(std::vector<orb::Descriptor>* descriptors, std::vector<WordPlace>* places) {
    std::stable_sort(clusters_.begin(), clusters_.end(), [](const Cluster& a, const Cluster& b) {
      return a.majority.count() > b.majority.count();
    });
    clusters_.resize(std::min(clusters_.size(), kWordsPerView));
    for (const Cluster& cluster : clusters_) {
      descriptors->push_back(cluster.majority.value());
      places->push_back(cluster.place);
    }
  }

 private:
  void addFeature(const orb::Descriptor& descriptor, const WordPlace& place) {
    const auto same = std::find_if(clusters_.begin(), clusters_.end(), [&](const Cluster& cluster) {
      return isSameWord(cluster, descriptor, place);
    });
    if (same == clusters_.end()) {
      clusters_.push_back({descriptor, place, {}});
      clusters_.back().majority.add(descriptor);
    } else {
      same->majority.add(descriptor);
    }
  }

  std::uint32_t object_class_;
  std::uint32_t view_;
  std::vector<Cluster> clusters_;
};

}  // namespace

WordIndex trainWords(const Samples& samples) {
  std::vector<orb::Descriptor> descriptors;
  std::vector<WordPlace> places;
  for (std::uint32_t i = 0; i < samples.views.size(); ++i) {
    const Samples::View& sample = samples.views[i];
    ViewWords words(sample.object_class, i);
    for (const int side : kSides) {
      const double area = std::pow(side + 64.0, 2.0);
      const orb::OrbConfig config{.features = static_cast<int>(kFeatures * 640.0 * 480.0 / area)};
      orb::OrbExtractor extractor(config);
      const auto addRendering = [&](double tilt, double direction) {
        const View view = renderView(sample.sample, side, tilt, direction);
        words.add(extractor.extract(view.grey), view, side, config.scale_factor);
      };
      addRendering(0.0, 0.0);
      for (const double direction : kDirections) {
        addRendering(kTilt, direction * std::numbers::pi);
      }
    }
    words.moveMostSeen(&descriptors, &places);
  }
  return {std::move(descriptors), std::move(places)};
}

}  // namespace rubble::recognizer
