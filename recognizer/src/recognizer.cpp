#include "recognizer/recognizer.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "common/error.h"
#include "hypotheses.h"
#include "outlines.h"
#include "patch_descriptor.h"
#include "solids/solid_detector.h"
#include "vocabulary_data.h"

namespace rubble::recognizer {

namespace {

/// Outlines are often a line drawn inside a label's border: patches are cut at both sizes.
constexpr std::array kSizes = {1.0F, 1.12F};
constexpr double kSharpSide = 70.0;  // px; smaller ones are cut from the larger picture
// Of one object, of two detections' bounding rectangles.
constexpr double kOverlap = 0.3;
constexpr double kContainment = 0.6;

/// Share of a solid thing's box from which on a label in it is what was taken for it.
constexpr float kExplained = 0.25F;

struct Found {
  Quad quad;
  std::uint32_t object_class = 0;
  float score = 0;
};

/// The picture in colour at the features' size and at its own, if that is larger.
struct Pictures {
  cv::Mat small;
  cv::Mat large;
  float scale = 1.0F;  // large to small

  cv::Mat cut(const Quad& quad) const {
    const bool is_small = scale < 1.0F && areaOf(quad) < kSharpSide * kSharpSide;
    return is_small ? rectified(large, rescaled(quad, 1.0F / scale), kPatchSide)
                    : rectified(small, quad, kPatchSide);
  }
};

Pictures picturesOf(const cv::Mat& picture, const orb::Features& features) {
  if (picture.type() != CV_8UC3 && picture.type() != CV_8UC1) {
    throw common::Error("recogniser: a picture is 8-bit BGR or grey");
  }
  Pictures pictures;
  if (picture.channels() == 1) {
    cv::cvtColor(picture, pictures.large, cv::COLOR_GRAY2BGR);
  } else {
    pictures.large = picture;
  }
  const cv::Size size(features.width, features.height);
  pictures.scale = static_cast<float>(features.width) / static_cast<float>(picture.cols);
  if (size == picture.size()) {
    pictures.small = pictures.large;
  } else {
    cv::resize(pictures.large, pictures.small, size, 0.0, 0.0,
               pictures.scale < 1.0F ? cv::INTER_AREA : cv::INTER_LINEAR);
  }
  return pictures;
}

bool explains(const Quad& label, const cv::Rect2f& box) {
  return (boundsOf(label) & box).area() > kExplained * box.area();
}

}  // namespace

struct Recognizer::State {
  RecognizerConfig config;
  std::shared_ptr<const Vocabulary> vocabulary;
  std::vector<WordMatch> matches;

  std::vector<Quad> findCandidates(const orb::Features& features, const cv::Mat& picture) {
    if (vocabulary->viewCount() == 0) {
      return {};
    }
    const WordIndex& words = vocabulary->data().words;
    matches.resize(features.size());
    words.match(features.descriptors, config.distance, matches);
    std::vector<Quad> candidates;
    for (const Hypothesis& hypothesis : findHypotheses(features, matches, words, config)) {
      candidates.push_back(hypothesis.quad);
    }
    for (const Outline& outline : findOutlines(picture, config.smallest_side)) {
      candidates.push_back(outline.quad);
    }
    candidates.resize(std::min(candidates.size(), static_cast<std::size_t>(config.candidates)));
    return candidates;
  }

  /// Every view's best likeness over the sizes that the patch is cut at.
  std::vector<AppearanceModel::Likeness> likenessesOf(const Quad& quad, const Pictures& pictures,
                                                      std::vector<float>* sizes) const {
    const AppearanceModel& appearance = vocabulary->data().appearance;
    std::vector<AppearanceModel::Likeness> best(vocabulary->viewCount());
    sizes->assign(best.size(), 1.0F);
    for (const float size : kSizes) {
      const auto likenesses = appearance.likenesses(describePatch(pictures.cut(scaled(quad, size))));
      for (std::size_t i = 0; i < best.size(); ++i) {
        if (likenesses[i].value > best[i].value) {
          best[i] = likenesses[i];
          (*sizes)[i] = size;
        }
      }
    }
    return best;
  }

  std::optional<Found> lookAt(const Quad& candidate, const Pictures& pictures) const {
    const VocabularyData& data = vocabulary->data();
    std::vector<float> sizes;
    const auto likenesses = likenessesOf(candidate, pictures, &sizes);
    const Verdict verdict = judge(likenesses, data.view_classes);
    const std::size_t best = verdict.view;
    const std::uint32_t object_class = data.view_classes[best];
    const float score = verdict.score - data.appearance.clutter_score;
    if (static_cast<double>(score) < config.score) {
      return std::nullopt;
    }
    return Found{turned(scaled(candidate, sizes[best]), likenesses[best].quarters), object_class, score};
  }

  /// What is not flat, unless labels explain it: these are told from clutter more reliably.
  void addSolids(const cv::Mat& picture, std::vector<Detection>* detections) const {
    const std::vector<Detection> labels = *detections;
    for (const FoundSolid& solid :
         findSolids(picture, vocabulary->data().solids, config.smallest_solid, config.solid_score)) {
      if (std::none_of(labels.begin(), labels.end(),
                       [&](const Detection& label) { return explains(label.quad, solid.box); })) {
        detections->push_back(
            detectionOf({quadOf(solid.box), solid.object_class, std::min(solid.score, 1.0F)}));
      }
    }
  }

  Detection detectionOf(const Found& found) const {
    const ObjectClass& object_class = vocabulary->classes()[found.object_class];
    return {.class_name = object_class.name,
            .kind = object_class.kind,
            .text = {},
            .score = found.score,
            .quad = found.quad,
            .width = object_class.width,
            .height = object_class.height};
  }
};

Recognizer::Recognizer(const RecognizerConfig& config, std::shared_ptr<const Vocabulary> vocabulary)
    : state_(std::make_unique<State>(State{config, std::move(vocabulary), {}})) {}
Recognizer::~Recognizer() = default;
Recognizer::Recognizer(Recognizer&&) noexcept = default;
Recognizer& Recognizer::operator=(Recognizer&&) noexcept = default;

std::vector<Detection> Recognizer::recognise(const orb::Features& features, const cv::Mat& picture,
                                             bool with_solids) {
  const Pictures pictures = picturesOf(picture, features);
  std::vector<Found> found;
  for (const Quad& candidate : state_->findCandidates(features, pictures.small)) {
    if (const auto object = state_->lookAt(candidate, pictures)) {
      found.push_back(*object);
    }
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const Found& a, const Found& b) { return a.score > b.score; });
  std::vector<Detection> detections;
  for (const Found& object : found) {
    const cv::Rect2f bounds = boundsOf(object.quad);
    if (std::none_of(detections.begin(), detections.end(), [&](const Detection& better) {
          const cv::Rect2f other = boundsOf(better.quad);
          return overlap(bounds, other) > kOverlap || containment(bounds, other) > kContainment;
        })) {
      detections.push_back(state_->detectionOf(object));
    }
  }
  if (with_solids) {
    state_->addSolids(pictures.small, &detections);
  }
  return detections;
}

}  // namespace rubble::recognizer
