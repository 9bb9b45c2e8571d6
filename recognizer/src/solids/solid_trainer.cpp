#include "solids/solid_trainer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "solids/solid_detector.h"
#include "solids/solid_rendering.h"

namespace rubble::recognizer {

namespace {

constexpr int kSeed = 9;
constexpr int kClutterPictures = 20;
const cv::Size kClutterSize(480, 360);
/// Shapes (width to height) that one model stands for: the widest to the narrowest.
constexpr double kShapeRange = 3.0;
/// Trees after each round; before every round what the last one takes for objects is added to the others.
constexpr std::array kRounds = {40, 120, 320};
/// Of objects that nothing was learnt from, that the cascade may lose: while clutter is looked for that it
/// takes for objects, and in the end, where hardly more than the stronger half is reported anyway.
constexpr double kLost = 0.05;
constexpr double kLostAtLast = 0.2;
/// One picture in so many is not learnt from, but tells what clutter reaches, in one of kReached of them.
constexpr std::size_t kHeldOut = 5;
constexpr std::size_t kReached = 4;
constexpr double kSmallestSide = 44.0;
/// Sum from which on a window is hard.
constexpr float kHard = -0.5F;

/// Samples of one class whose shapes are alike.
struct Group {
  std::uint32_t object_class = 0;
  double shape = 1.0;  // width to height
  std::vector<const SamplePicture*> samples;
};

double logShape(const SamplePicture& sample) {
  const cv::Rect2f box = boundsOf(sample.outline);
  return std::log(static_cast<double>(box.width / box.height));
}

std::vector<Group> groupsOf(const Samples& samples, std::uint32_t object_class) {
  std::vector<const SamplePicture*> sorted;
  for (const Samples::View& view : samples.views) {
    if (view.object_class == object_class) {
      sorted.push_back(&view.sample);
    }
  }
  std::stable_sort(sorted.begin(), sorted.end(), [](const SamplePicture* a, const SamplePicture* b) {
    return logShape(*a) < logShape(*b);
  });
  const double range = logShape(*sorted.back()) - logShape(*sorted.front());
  const int count = std::max(1, static_cast<int>(std::ceil(range / std::log(kShapeRange))));
  std::vector<Group> groups;
  for (int i = 0; i < count; ++i) {
    Group group{object_class, 0.0, {}};
    for (const SamplePicture* sample : sorted) {
      const double place = (logShape(*sample) - logShape(*sorted.front())) / std::max(range, 1e-9);
      if (std::min(count - 1, static_cast<int>(place * count)) == i) {
        group.samples.push_back(sample);
        group.shape += logShape(*sample);
      }
    }
    if (!group.samples.empty()) {
      group.shape = std::exp(group.shape / static_cast<double>(group.samples.size()));
      groups.push_back(std::move(group));
    }
  }
  return groups;
}

using Pyramid = std::vector<PyramidLevel>;

/// Mirrored, its colours exchanged: print and paint may have any.
cv::Mat recoloured(const cv::Mat& picture, cv::RNG* random) {
  constexpr std::array<std::array<int, 3>, 5> kOrders = {
      {{0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};
  const auto& order = kOrders[static_cast<std::size_t>(random->uniform(0, static_cast<int>(kOrders.size())))];
  std::vector<cv::Mat> channels;
  cv::split(picture, channels);
  cv::Mat result;
  cv::merge(std::vector<cv::Mat>{channels[static_cast<std::size_t>(order[0])],
                                 channels[static_cast<std::size_t>(order[1])],
                                 channels[static_cast<std::size_t>(order[2])]},
            result);
  cv::flip(result, result, 1);
  return result;
}

class Trainer {
 public:
  Trainer(const Samples& samples, const SolidTrainerConfig& config)
      : config_(config), random_(kSeed), pictures_(samples.backgrounds) {
    for (int i = 0; i < kClutterPictures; ++i) {
      pictures_.push_back(renderClutter(kClutterSize, &random_));
    }
    for (std::size_t i = 0; i < pictures_.size(); ++i) {
      const bool is_held_out = i % kHeldOut == 0;
      (is_held_out ? held_out_ : mined_).push_back(makePyramid(pictures_[i], kSmallestSide));
      if (!is_held_out && i < samples.backgrounds.size()) {
        mined_.push_back(makePyramid(recoloured(pictures_[i], &random_), kSmallestSide));
      }
    }
    for (const Samples::View& view : samples.views) {
      if (samples.classes[view.object_class].kind != kSolidKind) {
        flat_.push_back(cutOut(view.sample));
      }
    }
  }

  SolidModel train(const Group& group) {
    SolidModel model;
    model.object_class = group.object_class;
    const auto cells = [](double side) {
      return static_cast<int>(std::lround(side / kCellSide)) + 2 * kWindowMargin;
    };
    model.columns = cells(kObjectSide * std::sqrt(group.shape));
    model.rows = cells(kObjectSide / std::sqrt(group.shape));
    std::vector<CutOut> samples;
    for (const SamplePicture* sample : group.samples) {
      samples.push_back(cutOut(*sample));
    }
    const WindowTable objects = render(samples, model, config_.renderings);
    const WindowTable fresh = render(samples, model, config_.renderings / 4);
    WindowTable others = windowsAnywhere(model);
    if (!flat_.empty()) {  // A label is no victim.
      const WindowTable flat = render(flat_, model, config_.others / 4);
      others.values.insert(others.values.end(), flat.values.begin(), flat.values.end());
    }
    for (const int trees : kRounds) {
      model.trees = boostTrees(objects, others, trees);
      setCascade(fresh, kLost, &model.trees);
      if (trees != kRounds.back()) {
        addHard(model, &others);
      }
    }
    setTypical(fresh, &model);
    setZero(&model);
    setCascade(fresh, kLostAtLast, &model.trees);
    return model;
  }

 private:
  WindowTable render(const std::vector<CutOut>& samples, const SolidModel& model, int count) {
    WindowTable table{model.width(), {}};
    const cv::Size window(model.columns * kCellSide, model.rows * kCellSide);
    const int margin = 2 * kRenderedMargin * kCellSide;
    for (int i = 0; i < count; ++i) {
      const CutOut& sample = samples[static_cast<std::size_t>(i) % samples.size()];
      const cv::Mat background = cropAnywhere(pictures_, window + cv::Size(margin, margin), &random_);
      const Channels channels = channelsOf(renderSolid(sample, background, window, &random_));
      add(channels, kRenderedMargin, kRenderedMargin, model, &table);
    }
    return table;
  }

  WindowTable windowsAnywhere(const SolidModel& model) {
    WindowTable table{model.width(), {}};
    const int margin = 2 * kRenderedMargin;
    const cv::Size size((model.columns + margin) * kCellSide, (model.rows + margin) * kCellSide);
    for (int i = 0; i < config_.others / 2; ++i) {
      add(channelsOf(cropAnywhere(pictures_, size, &random_)), kRenderedMargin, kRenderedMargin, model,
          &table);
    }
    return table;
  }

  struct Place {
    std::size_t level;
    int row, column;
    float sum;
  };

  /// Windows that the model takes for objects, at most so many of one picture.
  void addHard(const SolidModel& model, WindowTable* others) const {
    const std::size_t most = static_cast<std::size_t>(config_.others) / pictures_.size() + 1;
    for (const Pyramid& pyramid : mined_) {
      for (const Place& place : hardest(model, pyramid, most)) {
        add(pyramid[place.level].channels, place.row, place.column, model, others);
      }
    }
  }

  /// The hardest first; of windows that hardly differ one.
  static std::vector<Place> hardest(const SolidModel& model, const Pyramid& pyramid, std::size_t most) {
    std::vector<Place> all;
    for (std::size_t level = 0; level < pyramid.size(); ++level) {
      scanWindows(pyramid[level].channels, model, [&](int row, int column, float sum) {
        if (sum > kHard) {
          all.push_back({level, row, column, sum});
        }
      });
    }
    std::stable_sort(all.begin(), all.end(), [](const Place& a, const Place& b) { return a.sum > b.sum; });
    std::vector<Place> hard;
    for (const Place& place : all) {
      const bool is_known = std::any_of(hard.begin(), hard.end(), [&](const Place& known) {
        return known.level == place.level && std::abs(known.row - place.row) <= 1 &&
               std::abs(known.column - place.column) <= 1;
      });
      if (!is_known && hard.size() < most) {
        hard.push_back(place);
      }
    }
    return hard;
  }

  static void add(const Channels& channels, int row, int column, const SolidModel& model,
                  WindowTable* table) {
    for (int i = 0; i < model.rows; ++i) {
      const std::uint8_t* begin = channels.at(row + i, column);
      table->values.insert(table->values.end(), begin, begin + model.columns * kChannels);
    }
  }

  static void setTypical(const WindowTable& objects, SolidModel* model) {
    std::vector<float> sums;
    for (std::size_t i = 0; i < objects.rows(); ++i) {
      sums.push_back(sumOf(model->trees, objects.row(i)));
    }
    const auto middle = sums.begin() + static_cast<std::ptrdiff_t>(sums.size() / 2);
    std::nth_element(sums.begin(), middle, sums.end());
    model->typical = *middle;
  }

  void setZero(SolidModel* model) const {
    std::vector<float> best;
    for (const Pyramid& pyramid : held_out_) {
      best.push_back(-1.0F);
      for (const PyramidLevel& level : pyramid) {
        scanWindows(level.channels, *model,
                    [&](int, int, float sum) { best.back() = std::max(best.back(), sum); });
      }
    }
    const auto high = best.begin() + static_cast<std::ptrdiff_t>(best.size() - 1 - best.size() / kReached);
    std::nth_element(best.begin(), high, best.end());
    model->zero = std::min(*high, model->typical - 1.0F);
  }

  const SolidTrainerConfig config_;
  cv::RNG random_;
  std::vector<cv::Mat> pictures_;
  std::vector<Pyramid> held_out_;  // of some pictures
  std::vector<Pyramid> mined_;     // of the others, backgrounds twice
  std::vector<CutOut> flat_;       // samples of other kinds
};

}  // namespace

std::vector<SolidModel> trainSolids(const Samples& samples, const SolidTrainerConfig& config) {
  std::vector<SolidModel> models;
  for (std::uint32_t i = 0; i < samples.classes.size(); ++i) {
    if (samples.classes[i].kind != kSolidKind) {
      continue;
    }
    Trainer trainer(samples, config);
    const std::vector<Group> groups = groupsOf(samples, i);
    for (const Group& group : groups) {
      models.push_back(trainer.train(group));
    }
  }
  return models;
}

}  // namespace rubble::recognizer
