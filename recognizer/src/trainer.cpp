#include "recognizer/trainer.h"

#include <algorithm>

#include "outlines.h"
#include "patch_descriptor.h"
#include "rendering.h"
#include "samples.h"
#include "solids/solid_trainer.h"
#include "vocabulary_data.h"
#include "word_trainer.h"

namespace rubble::recognizer {

namespace {

constexpr int kSeed = 7;
constexpr int kPatchesPerPicture = 24;
constexpr int kPlacesPerPicture = 4;  // anywhere, besides outlines
const cv::Size kClutterSize(480, 360);

Eigen::MatrixXf describeRenderings(const SamplePicture& sample, int count, cv::RNG* random) {
  Eigen::MatrixXf rows(count, kPatchDimensions);
  for (int i = 0; i < count; ++i) {
    rows.row(i) = describePatch(renderPatch(sample, random)).transpose();
  }
  return rows;
}

Quad squareAnywhere(cv::RNG* random) {
  const float side = random->uniform(20.0F, 90.0F);
  const cv::RotatedRect square(
      cv::Point2f(random->uniform(40.0F, static_cast<float>(kClutterSize.width) - 40.0F),
                  random->uniform(40.0F, static_cast<float>(kClutterSize.height) - 40.0F)),
      cv::Size2f(side, side), random->uniform(0.0F, 360.0F));
  Quad quad;
  square.points(quad.data());
  return quad;
}

Eigen::MatrixXf describeClutter(int count, cv::RNG* random) {
  constexpr double kSmallestSide = 18.0;
  Eigen::MatrixXf rows(count, kPatchDimensions);
  Eigen::Index row = 0;
  while (row < rows.rows()) {
    const cv::Mat picture = renderClutter(kClutterSize, random);
    std::vector<Quad> quads;
    for (int i = 0; i < kPlacesPerPicture; ++i) {
      quads.push_back(squareAnywhere(random));
    }
    for (const Outline& outline : findOutlines(picture, kSmallestSide)) {
      quads.push_back(outline.quad);
    }
    quads.resize(std::min<std::size_t>(quads.size(), kPatchesPerPicture));
    for (std::size_t i = 0; i < quads.size() && row < rows.rows(); ++i) {
      const Quad quad = scaled(quads[i], random->uniform(0.95F, 1.2F));
      rows.row(row++) = describePatch(rectified(picture, quad, kPatchSide)).transpose();
    }
  }
  return rows;
}

/// The score that one in a hundred of patches reaches.
float highScore(const Eigen::MatrixXf& patches, const AppearanceModel& model,
                const std::vector<std::uint32_t>& view_classes) {
  std::vector<float> scores;
  for (Eigen::Index i = 0; i < patches.rows(); ++i) {
    scores.push_back(judge(model.likenesses(patches.row(i).transpose()), view_classes).score);
  }
  const auto high = scores.begin() + static_cast<std::ptrdiff_t>(scores.size() * 99 / 100);
  std::nth_element(scores.begin(), high, scores.end());
  return *high;
}

Samples withoutSolids(const Samples& all) {
  Samples flat{all.classes, {}, {}};
  std::copy_if(all.views.begin(), all.views.end(), std::back_inserter(flat.views),
               [&](const Samples::View& view) { return all.classes[view.object_class].kind != kSolidKind; });
  return flat;
}

}  // namespace

Vocabulary train(const std::vector<std::filesystem::path>& folders, const TrainerConfig& config) {
  const Samples all = readSamples(folders);
  VocabularyData data;
  data.classes = all.classes;
  data.solids = trainSolids(all, {.renderings = config.solids, .others = config.solids});
  const Samples samples = withoutSolids(all);
  data.words = trainWords(samples);
  if (samples.views.empty()) {
    data.appearance = AppearanceModel::empty();
    return Vocabulary(std::move(data));
  }
  cv::RNG random(kSeed);
  std::vector<Eigen::MatrixXf> views;
  for (const Samples::View& view : samples.views) {
    data.view_classes.push_back(view.object_class);
    views.push_back(describeRenderings(view.sample, config.renderings, &random));
  }
  data.appearance = trainAppearance(views, describeClutter(config.clutter, &random));
  data.appearance.clutter_score =
      highScore(describeClutter(config.clutter / 3, &random), data.appearance, data.view_classes);
  return Vocabulary(std::move(data));
}

}  // namespace rubble::recognizer
