#include "solids/boosted_trees.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/core.hpp>

#include "common/error.h"

namespace rubble::recognizer {

namespace {

constexpr int kSeed = 11;
/// Values that are looked at for a tree: one in so many, others for every tree.
constexpr std::size_t kFeatureShare = 16;
constexpr float kPrior = 0.02F;     // weight on both sides of a leaf
constexpr float kShrinkage = 0.5F;  // of a leaf
/// Of the mean weight: windows of less do not choose splits (weight trimming).
constexpr float kIdle = 0.1F;

/// Columns of all windows, objects first, and their weights.
class Booster {
 public:
  Booster(const WindowTable& objects, const WindowTable& others)
      : width_(objects.width),
        objects_(objects.rows()),
        rows_(objects.rows() + others.rows()),
        random_(kSeed) {
    columns_.resize(width_ * rows_);
    for (std::size_t i = 0; i < rows_; ++i) {
      const auto row = i < objects_ ? objects.row(i) : others.row(i - objects_);
      for (std::size_t f = 0; f < width_; ++f) {
        columns_[f * rows_ + i] = row[f];
      }
    }
    sums_.assign(rows_, 0.0F);
    weights_.resize(rows_);
    nodes_.resize(rows_);
  }

  BoostedTrees::Tree next() {
    weigh();
    std::fill(nodes_.begin(), nodes_.end(), std::uint8_t{0});
    const std::vector<std::size_t> features = someFeatures();
    BoostedTrees::Tree tree{};
    for (int depth = 0; depth < BoostedTrees::kDepth; ++depth) {
      split(features, depth, &tree);
    }
    setLeaves(&tree);
    return tree;
  }

 private:
  using Side = std::array<float, 2>;  // weight of others, of objects

  std::size_t isObject(std::size_t row) const { return row < objects_ ? 1 : 0; }

  /// Logistic loss.
  void weigh() {
    Side totals{};
    for (std::size_t i = 0; i < rows_; ++i) {
      const float margin = isObject(i) == 1 ? sums_[i] : -sums_[i];
      weights_[i] = 1.0F / (1.0F + std::exp(2.0F * margin));
      totals[isObject(i)] += weights_[i];
    }
    if (totals_[0] == 0.0F) {
      totals_ = totals;  // Both sides weigh the same at first.
    }
    float sum = 0.0F;
    for (std::size_t i = 0; i < rows_; ++i) {
      weights_[i] /= totals_[isObject(i)];
      sum += weights_[i];
    }
    active_.clear();
    for (std::size_t i = 0; i < rows_; ++i) {
      if (weights_[i] * static_cast<float>(rows_) >= kIdle * sum) {
        active_.push_back(static_cast<std::uint32_t>(i));
      }
    }
  }

  std::vector<std::size_t> someFeatures() {
    std::vector<std::size_t> features;
    for (std::size_t i = 0; i < std::max<std::size_t>(1, width_ / kFeatureShare); ++i) {
      features.push_back(static_cast<std::size_t>(random_.uniform(0, static_cast<int>(width_))));
    }
    return features;
  }

  /// The best split of every node of a depth, and where its windows go.
  void split(const std::vector<std::size_t>& features, int depth, BoostedTrees::Tree* tree) {
    const std::size_t count = std::size_t{1} << depth;
    const std::size_t first = count - 1;
    std::vector<float> best(count, -1.0F);
    std::vector<std::array<Side, 256>> histograms(count);
    for (const std::size_t feature : features) {
      for (auto& histogram : histograms) {
        histogram.fill({});
      }
      const std::uint8_t* column = &columns_[feature * rows_];
      for (const std::uint32_t i : active_) {
        histograms[nodes_[i] - first][column[i]][isObject(i)] += weights_[i];
      }
      for (std::size_t node = 0; node < count; ++node) {
        const auto [gain, threshold] = bestThreshold(histograms[node]);
        if (gain > best[node]) {
          best[node] = gain;
          tree->features[first + node] = static_cast<std::uint16_t>(feature);
          tree->thresholds[first + node] = threshold;
        }
      }
    }
    for (std::size_t i = 0; i < rows_; ++i) {
      const std::size_t node = nodes_[i];
      const bool is_above = columns_[tree->features[node] * rows_ + i] >= tree->thresholds[node];
      nodes_[i] = static_cast<std::uint8_t>(2 * node + (is_above ? 2 : 1));
    }
  }

  /// Gain by how much purer both sides are (Gini); values below the threshold go left.
  static std::pair<float, std::uint8_t> bestThreshold(const std::array<Side, 256>& histogram) {
    Side total{};
    for (const Side& bin : histogram) {
      total[0] += bin[0];
      total[1] += bin[1];
    }
    const auto purity = [](const Side& side) {
      const float sum = side[0] + side[1];
      return sum > 1e-9F ? (side[0] * side[0] + side[1] * side[1]) / sum : 0.0F;
    };
    std::pair<float, std::uint8_t> best{0.0F, std::uint8_t{0}};
    Side below{};
    for (std::size_t value = 1; value < histogram.size(); ++value) {
      below[0] += histogram[value - 1][0];
      below[1] += histogram[value - 1][1];
      const float sum = purity(below) + purity({total[0] - below[0], total[1] - below[1]});
      if (sum > best.first) {
        best = {sum, static_cast<std::uint8_t>(value)};
      }
    }
    return best;
  }

  void setLeaves(BoostedTrees::Tree* tree) {
    std::array<Side, BoostedTrees::kLeaves> leaves{};
    for (std::size_t i = 0; i < rows_; ++i) {
      leaves[nodes_[i] - BoostedTrees::kNodes][isObject(i)] += weights_[i];
    }
    const float prior = kPrior * (totalOf(leaves, 0) + totalOf(leaves, 1));
    for (std::size_t i = 0; i < leaves.size(); ++i) {
      tree->leaves[i] = kShrinkage * 0.5F * std::log((leaves[i][1] + prior) / (leaves[i][0] + prior));
    }
    for (std::size_t i = 0; i < rows_; ++i) {
      sums_[i] += tree->leaves[nodes_[i] - BoostedTrees::kNodes];
    }
  }
  static float totalOf(const std::array<Side, BoostedTrees::kLeaves>& leaves, std::size_t side) {
    return std::accumulate(leaves.begin(), leaves.end(), 0.0F,
                           [&](float sum, const Side& leaf) { return sum + leaf[side]; });
  }

  const std::size_t width_;
  const std::size_t objects_;
  const std::size_t rows_;
  cv::RNG random_;
  std::vector<std::uint8_t> columns_;
  std::vector<float> sums_;
  std::vector<float> weights_;
  std::vector<std::uint8_t> nodes_;
  std::vector<std::uint32_t> active_;  // rows that weigh enough to be counted
  Side totals_{};
};

float leafOf(const BoostedTrees::Tree& tree, std::span<const std::uint8_t> window) {
  std::size_t node = 0;
  for (int depth = 0; depth < BoostedTrees::kDepth; ++depth) {
    node = 2 * node + (window[tree.features[node]] >= tree.thresholds[node] ? 2 : 1);
  }
  return tree.leaves[node - BoostedTrees::kNodes];
}

}  // namespace

BoostedTrees boostTrees(const WindowTable& objects, const WindowTable& others, int count) {
  RUBBLE_CHECK(objects.width == others.width && objects.rows() > 0 && others.rows() > 0);
  Booster booster(objects, others);
  BoostedTrees result;
  for (int i = 0; i < count; ++i) {
    result.trees.push_back(booster.next());
    result.trees.back().least = -1e9F;
  }
  return result;
}

float sumOf(const BoostedTrees& trees, std::span<const std::uint8_t> window) {
  float sum = 0.0F;
  for (const BoostedTrees::Tree& tree : trees.trees) {
    sum += leafOf(tree, window);
  }
  return sum;
}

void setCascade(const WindowTable& objects, double share, BoostedTrees* trees) {
  std::vector<float> finals;
  for (std::size_t i = 0; i < objects.rows(); ++i) {
    finals.push_back(sumOf(*trees, objects.row(i)));
  }
  const auto weakest =
      finals.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(finals.size()));
  std::vector<float> sorted = finals;
  const auto nth = sorted.begin() + (weakest - finals.begin());
  std::nth_element(sorted.begin(), nth, sorted.end());
  const float kept_from = *nth;
  std::vector<float> sums(finals.size(), 0.0F);
  for (BoostedTrees::Tree& tree : trees->trees) {
    tree.least = 1e9F;
    for (std::size_t i = 0; i < finals.size(); ++i) {
      sums[i] += leafOf(tree, objects.row(i));
      if (finals[i] >= kept_from) {
        tree.least = std::min(tree.least, sums[i]);
      }
    }
  }
}

}  // namespace rubble::recognizer
