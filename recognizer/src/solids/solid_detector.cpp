#include "solids/solid_detector.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "quad.h"

namespace rubble::recognizer {

namespace {

constexpr double kLevelsPerOctave = 4.0;
constexpr int kBorder = 2 * kCellSide;  // px, at every level
constexpr int kSmallestLevel = 12;      // cells
// Of one object, of two boxes.
constexpr double kOverlap = 0.15;
constexpr double kContainment = 0.3;

/// Trees whose features are offsets into one level's channels.
struct PlacedTree {
  std::array<std::int32_t, BoostedTrees::kNodes> offsets;
  std::array<std::uint8_t, BoostedTrees::kNodes> thresholds;
  std::array<float, BoostedTrees::kLeaves> leaves;
  float least;
};

std::vector<PlacedTree> placed(const SolidModel& model, int stride) {
  std::vector<PlacedTree> trees;
  const int width = model.columns * kChannels;
  for (const BoostedTrees::Tree& tree : model.trees.trees) {
    PlacedTree& result = trees.emplace_back();
    for (std::size_t i = 0; i < tree.features.size(); ++i) {
      result.offsets[i] = tree.features[i] / width * stride + tree.features[i] % width;
    }
    result.thresholds = tree.thresholds;
    result.leaves = tree.leaves;
    result.least = tree.least;
  }
  return trees;
}

}  // namespace

void scanWindows(const Channels& channels, const SolidModel& model, const WindowVisitor& visit) {
  const std::vector<PlacedTree> trees = placed(model, channels.stride());
  for (int row = 0; row + model.rows <= channels.rows; ++row) {
    for (int column = 0; column + model.columns <= channels.columns; ++column) {
      const std::uint8_t* window = channels.at(row, column);
      float sum = 0.0F;
      bool is_rejected = false;
      for (const PlacedTree& tree : trees) {
        std::size_t node = 0;
        for (int depth = 0; depth < BoostedTrees::kDepth; ++depth) {
          node = 2 * node + (window[tree.offsets[node]] >= tree.thresholds[node] ? 2 : 1);
        }
        sum += tree.leaves[node - BoostedTrees::kNodes];
        if (sum < tree.least) {
          is_rejected = true;
          break;
        }
      }
      if (!is_rejected) {
        visit(row, column, sum);
      }
    }
  }
}

cv::Rect2f PyramidLevel::boxOf(const SolidModel& model, int row, int column) const {
  const auto pixel = [&](int x, int y) {
    return cv::Point2f(static_cast<float>(x * kCellSide - kBorder) / scale.x - 0.5F,
                       static_cast<float>(y * kCellSide - kBorder) / scale.y - 0.5F);
  };
  return {pixel(column + kWindowMargin, row + kWindowMargin),
          pixel(column + model.columns - kWindowMargin, row + model.rows - kWindowMargin)};
}

std::vector<PyramidLevel> makePyramid(const cv::Mat& picture, double smallest_side) {
  std::vector<PyramidLevel> levels;
  double factor = kObjectSide / smallest_side;
  cv::Mat source = picture;
  while (true) {
    const auto fitted = [&](int side) {
      return static_cast<int>(std::lround(factor * side / kCellSide)) * kCellSide;
    };
    const cv::Size size(fitted(picture.cols), fitted(picture.rows));
    if (std::min(size.width, size.height) + 2 * kBorder < kSmallestLevel * kCellSide) {
      return levels;
    }
    // An octave's levels are made of the last octave's: less to read.
    cv::Mat level;
    cv::resize(source, level, size, 0.0, 0.0,
               2 * size.width == source.cols ? cv::INTER_AREA : cv::INTER_LINEAR);
    if (2 * size.width <= source.cols) {
      source = level;
    }
    cv::Mat bordered;
    cv::copyMakeBorder(level, bordered, kBorder, kBorder, kBorder, kBorder, cv::BORDER_REPLICATE);
    levels.push_back({channelsOf(bordered),
                      {static_cast<float>(size.width) / static_cast<float>(picture.cols),
                       static_cast<float>(size.height) / static_cast<float>(picture.rows)}});
    factor /= std::exp2(1.0 / kLevelsPerOctave);
  }
}

std::vector<FoundSolid> findSolids(const cv::Mat& picture, const std::vector<SolidModel>& models,
                                   double smallest_side, double score) {
  std::vector<FoundSolid> all;
  if (models.empty()) {
    return all;
  }
  for (const PyramidLevel& level : makePyramid(picture, smallest_side)) {
    for (const SolidModel& model : models) {
      scanWindows(level.channels, model, [&](int row, int column, float sum) {
        const float value = model.scoreOf(sum);
        if (static_cast<double>(value) >= score) {
          all.push_back({level.boxOf(model, row, column), model.object_class, value});
        }
      });
    }
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const FoundSolid& a, const FoundSolid& b) { return a.score > b.score; });
  std::vector<FoundSolid> best;
  for (const FoundSolid& found : all) {
    if (std::none_of(best.begin(), best.end(), [&](const FoundSolid& better) {
          return overlap(found.box, better.box) > kOverlap ||
                 containment(found.box, better.box) > kContainment;
        })) {
      best.push_back(found);
    }
  }
  return best;
}

}  // namespace rubble::recognizer
