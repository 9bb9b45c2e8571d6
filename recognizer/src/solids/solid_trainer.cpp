#include "solids/solid_trainer.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <opencv2/imgproc.hpp>

#include "solids/solid_detector.h"
#include "solids/solid_rendering.h"

namespace rubble::recognizer {

namespace {

constexpr int kSeed = 9;
constexpr int kClutterPictures = 60;
const cv::Size kClutterSize(480, 360);
/// Shapes (width to height) that one model stands for: the widest to the narrowest.
constexpr double kShapeRange = 2.0;
/// Trees after each round; before every round what the last one takes for objects is added to the others.
constexpr std::array kRounds = {32, 128, 256};
/// Of objects that nothing was learnt from, that the cascade may lose.
constexpr double kLost = 0.03;
constexpr double kSmallestSide = 44.0;

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

class Trainer {
 public:
  Trainer(const std::vector<cv::Mat>& backgrounds, const SolidTrainerConfig& config)
      : config_(config), random_(kSeed), pictures_(backgrounds) {
    for (const cv::Mat& background : backgrounds) {
      cv::Mat mirrored;
      cv::flip(background, mirrored, 1);
      pictures_.push_back(mirrored);
    }
    for (int i = 0; i < kClutterPictures; ++i) {
      pictures_.push_back(renderClutter(kClutterSize, &random_));
    }
  }

  SolidModel train(const Group& group, int renderings) {
    SolidModel model;
    model.object_class = group.object_class;
    const auto cells = [](double side) {
      return static_cast<int>(std::lround(side / kCellSide)) + 2 * kWindowMargin;
    };
    model.columns = cells(kObjectSide * std::sqrt(group.shape));
    model.rows = cells(kObjectSide / std::sqrt(group.shape));
    const WindowTable objects = render(group, model, renderings);
    const WindowTable fresh = render(group, model, renderings / 4);
    WindowTable others = windowsAnywhere(model);
    for (const int trees : kRounds) {
      model.trees = boostTrees(objects, others, trees);
      setCascade(fresh, kLost, &model.trees);
      if (trees != kRounds.back()) {
        addHard(model, &others);
      }
    }
    setTypical(fresh, &model);
    return model;
  }

 private:
  WindowTable render(const Group& group, const SolidModel& model, int count) {
    WindowTable table{model.width(), {}};
    const cv::Size window(model.columns * kCellSide, model.rows * kCellSide);
    const int margin = 2 * kRenderedMargin * kCellSide;
    for (int i = 0; i < count; ++i) {
      const SamplePicture& sample = *group.samples[static_cast<std::size_t>(i) % group.samples.size()];
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
    for (int i = 0; i < config_.others; ++i) {
      add(channelsOf(cropAnywhere(pictures_, size, &random_)), kRenderedMargin, kRenderedMargin, model, &table);
    }
    return table;
  }

  /// Windows that the model takes for objects, at most so many of one picture.
  void addHard(const SolidModel& model, WindowTable* others) {
    struct Hard {
      std::size_t level;
      int row, column;
      float sum;
    };
    const std::size_t most = static_cast<std::size_t>(config_.others) / pictures_.size() + 1;
    std::size_t all = 0;
    for (const cv::Mat& picture : pictures_) {
      const auto pyramid = makePyramid(picture, kSmallestSide);
      std::vector<Hard> hard;
      for (std::size_t level = 0; level < pyramid.size(); ++level) {
        scanWindows(pyramid[level].channels, model,
                    [&](int row, int column, float sum) { hard.push_back({level, row, column, sum}); });
      }
      all += hard.size();
      std::stable_sort(hard.begin(), hard.end(), [](const Hard& a, const Hard& b) { return a.sum > b.sum; });
      hard.resize(std::min(hard.size(), most));
      for (const Hard& window : hard) {
        add(pyramid[window.level].channels, window.row, window.column, model, others);
      }
    }
    std::fprintf(stderr, "hard %zu, others %zu\n", all, others->rows());
  }

  static void add(const Channels& channels, int row, int column, const SolidModel& model, WindowTable* table) {
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
    model->typical = std::max(*middle, 1e-3F);
  }

  const SolidTrainerConfig config_;
  cv::RNG random_;
  std::vector<cv::Mat> pictures_;
};

}  // namespace

std::vector<SolidModel> trainSolids(const Samples& samples, const SolidTrainerConfig& config) {
  std::vector<SolidModel> models;
  for (std::uint32_t i = 0; i < samples.classes.size(); ++i) {
    if (samples.classes[i].kind != kSolidKind) {
      continue;
    }
    Trainer trainer(samples.backgrounds, config);
    const std::vector<Group> groups = groupsOf(samples, i);
    std::size_t views = 0;
    for (const Group& group : groups) {
      views += group.samples.size();
    }
    for (const Group& group : groups) {
      std::fprintf(stderr, "group %.2f %zu\n", group.shape, group.samples.size());
      models.push_back(trainer.train(
          group, static_cast<int>(static_cast<std::size_t>(config.renderings) * group.samples.size() / views)));
    }
  }
  return models;
}

}  // namespace rubble::recognizer
