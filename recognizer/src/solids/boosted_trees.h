#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace rubble::recognizer {

/// A window of cells that looks like something or not, told by boosted trees with a soft cascade (Friedman,
/// Hastie and Tibshirani, "Additive logistic regression", Annals of Statistics 2000; Zhang and Viola,
/// "Multiple-instance pruning for learning efficient cascade detectors", NIPS 2007).
struct BoostedTrees {
  static constexpr int kDepth = 3;
  static constexpr int kNodes = (1 << kDepth) - 1;
  static constexpr int kLeaves = 1 << kDepth;

  struct Tree {
    std::array<std::uint16_t, kNodes> features;   ///< index into the window's values
    std::array<std::uint8_t, kNodes> thresholds;  ///< children of node i: 2 i + 1 where below, else 2 i + 2
    std::array<std::uint8_t, 3> padding{};        ///< trees are stored as they are
    std::array<float, kLeaves> leaves;
    float least = 0.0F;  ///< a sum lower than this after this tree is no object
  };
  std::vector<Tree> trees;
};

/// Windows' values: a row per window.
struct WindowTable {
  std::size_t width = 0;
  std::vector<std::uint8_t> values;

  std::size_t rows() const { return width == 0 ? 0 : values.size() / width; }
  std::span<const std::uint8_t> row(std::size_t i) const { return {&values[i * width], width}; }
};

/// `count` trees that tell `objects` from `others`; both weigh the same. Deterministic. Cascade not set.
BoostedTrees boostTrees(const WindowTable& objects, const WindowTable& others, int count);

/// Sum over all trees, without the cascade.
float sumOf(const BoostedTrees& trees, std::span<const std::uint8_t> window);

/// Sets the cascade so that it loses about `share` of `objects` (rows), the weakest ones.
void setCascade(const WindowTable& objects, double share, BoostedTrees* trees);

}  // namespace rubble::recognizer
