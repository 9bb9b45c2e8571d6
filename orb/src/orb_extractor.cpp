#include "orb/orb_extractor.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <span>

#include "common/error.h"
#include "corner_quadtree.h"
#include "fast_detector.h"
#include "orb_patch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "orb_extractor.cpp"
#include <hwy/foreach_target.h>
// foreach_target.h first, then highway.h
#include <hwy/highway.h>

#include "orb_kernels-inl.h"

#if HWY_ONCE
namespace rubble::orb {
namespace {

HWY_EXPORT(smoothPatches);
HWY_EXPORT(measureMoments);
HWY_EXPORT(describePatches);

constexpr int kSmallestSide = 64;
constexpr int kLargestSide = 16384;
constexpr double kPoorShare = 0.5;  // of the wanted features; a picture with fewer gives its faint ones too

struct Level {
  cv::Mat grey;
  cv::Mat smooth;
  std::vector<Corner> corners;
};

void validate(const OrbConfig& config) {
  const auto require = [](bool is_met, const char* text) {
    if (!is_met) {
      throw common::Error(fmt::format("ORB: {}", text));
    }
  };
  require(config.features > 0, "features must be above 0");
  require(config.scale_factor > 1.0 && config.scale_factor <= 4.0, "scale_factor must be above 1, at most 4");
  require(config.levels > 0 && config.levels <= 32, "levels must be 1 to 32");
  require(config.min_threshold > 0 && config.min_threshold <= config.threshold && config.threshold < 255,
          "thresholds must be 0 < min_threshold <= threshold < 255");
}

Direction directionOf(const Moments& moments) {
  const double length = std::hypot(moments.x, moments.y);
  if (length == 0.0) {
    return {};
  }
  const auto inSteps = [length](int part) {
    return static_cast<float>(std::nearbyint(1024.0 * part / length) / 1024.0);
  };
  return {inSteps(moments.x), inSteps(moments.y)};
}

}  // namespace

struct OrbExtractor::State {
  explicit State(const OrbConfig& orb_config)
      : config(orb_config),
        detector(config.threshold, config.min_threshold),
        faint_detector(config.min_threshold, std::max(1, config.min_threshold / 2)),
        levels(static_cast<std::size_t>(config.levels)) {}

  void buildPyramid(const cv::Mat& grey);
  /// At most `wanted`; their number.
  int pickCorners(FastDetector& by, int wanted);
  void pickCorners();
  void smooth(Level* level);
  void describe(const Level& level, std::uint8_t octave, Features* features);

  OrbConfig config;
  Disc disc;
  Pattern pattern;
  FastDetector detector;
  FastDetector faint_detector;  // of pictures that show next to nothing
  CornerQuadtree quadtree;
  std::vector<Level> levels;
  std::vector<std::uint8_t> row;
  std::vector<cv::Point2f> offsets;
  std::vector<Moments> moments;
  std::vector<Direction> directions;
};

void OrbExtractor::State::buildPyramid(const cv::Mat& grey) {
  levels.front().grey = grey;
  for (std::size_t i = 1; i < levels.size(); ++i) {
    const double scale = std::pow(config.scale_factor, -static_cast<double>(i));
    const cv::Size size(std::max(1, static_cast<int>(std::lround(grey.cols * scale))),
                        std::max(1, static_cast<int>(std::lround(grey.rows * scale))));
    cv::resize(levels[i - 1].grey, levels[i].grey, size, 0.0, 0.0, cv::INTER_LINEAR);
  }
}

int OrbExtractor::State::pickCorners(FastDetector& by, int wanted) {
  int picked = 0;
  // From the coarsest level on, so that what coarse levels lack goes to the finer ones.
  for (std::size_t i = levels.size(); i-- > 0;) {
    Level& level = levels[i];
    by.detect(level.grey, &level.corners);
    // Share of q^i in 1 + q + .. + q^i.
    const double q = 1.0 / config.scale_factor;
    const double share = std::pow(q, i) * (1.0 - q) / (1.0 - std::pow(q, i + 1));
    quadtree.thin(level.grey.cols, level.grey.rows, static_cast<int>(std::lround((wanted - picked) * share)),
                  &level.corners);
    picked += static_cast<int>(level.corners.size());
  }
  return picked;
}

void OrbExtractor::State::pickCorners() {
  const cv::Size size = levels.front().grey.size();
  const double area = static_cast<double>(size.width) * size.height / (640.0 * 480.0);
  const int wanted =
      static_cast<int>(std::clamp(std::round(config.features * area), 1.0, 1.0 * kMostFeatures));
  if (pickCorners(detector, wanted) < kPoorShare * wanted) {
    pickCorners(faint_detector, wanted);
  }
}

void OrbExtractor::State::smooth(Level* level) {
  level->smooth.create(level->grey.size(), CV_8UC1);
  row.resize(static_cast<std::size_t>(level->grey.cols) + kRowPadding);
  HWY_DYNAMIC_DISPATCH(smoothPatches)(level->grey, row.data(), &level->smooth);
}

void OrbExtractor::State::describe(const Level& level, std::uint8_t octave, Features* features) {
  const std::size_t count = level.corners.size();
  const std::size_t before = features->size();
  offsets.resize(count);
  FastDetector::refine(level.grey, level.corners, offsets.data());
  moments.resize(count);
  HWY_DYNAMIC_DISPATCH(measureMoments)(level.grey, disc, level.corners, moments.data());
  directions.resize(count);
  std::transform(moments.begin(), moments.end(), directions.begin(), directionOf);
  features->descriptors.resize(before + count);
  HWY_DYNAMIC_DISPATCH(describePatches)
  (level.smooth, pattern, level.corners, directions.data(), features->descriptors.data() + before);

  // From pixel centre to pixel centre, as cv::resize does it.
  const float scale_x = static_cast<float>(features->width) / static_cast<float>(level.grey.cols);
  const float scale_y = static_cast<float>(features->height) / static_cast<float>(level.grey.rows);
  for (std::size_t i = 0; i < count; ++i) {
    const Corner& corner = level.corners[i];
    features->x.push_back((static_cast<float>(corner.x) + offsets[i].x + 0.5F) * scale_x - 0.5F);
    features->y.push_back((static_cast<float>(corner.y) + offsets[i].y + 0.5F) * scale_y - 0.5F);
    features->angle.push_back(std::atan2(static_cast<float>(moments[i].y), static_cast<float>(moments[i].x)));
    features->octave.push_back(octave);
  }
}

OrbExtractor::OrbExtractor(const OrbConfig& config) {
  validate(config);
  state_ = std::make_unique<State>(config);
}

OrbExtractor::~OrbExtractor() = default;
OrbExtractor::OrbExtractor(OrbExtractor&&) noexcept = default;
OrbExtractor& OrbExtractor::operator=(OrbExtractor&&) noexcept = default;

Features OrbExtractor::extract(const cv::Mat& grey) {
  if (grey.type() != CV_8UC1 || std::min(grey.cols, grey.rows) < kSmallestSide ||
      std::max(grey.cols, grey.rows) > kLargestSide) {
    throw common::Error(
        fmt::format("ORB: the picture has {} x {} pixels of OpenCV type {}; needed are 8-bit grey, {} to {} "
                    "pixels a side",
                    grey.cols, grey.rows, grey.type(), kSmallestSide, kLargestSide));
  }
  state_->buildPyramid(grey);
  state_->pickCorners();
  Features features;
  features.width = grey.cols;
  features.height = grey.rows;
  for (std::size_t i = 0; i < state_->levels.size(); ++i) {
    Level& level = state_->levels[i];
    if (!level.corners.empty()) {
      state_->smooth(&level);
      state_->describe(level, static_cast<std::uint8_t>(i), &features);
    }
  }
  state_->levels.front().grey.release();  // the caller's
  return features;
}

}  // namespace rubble::orb
#endif  // HWY_ONCE
