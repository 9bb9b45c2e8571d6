#pragma once

#include <cstdint>

#include "solids/boosted_trees.h"
#include "solids/channels.h"

namespace rubble::recognizer {

/// How large an object is in its window (root of its box's area), pixels.
inline constexpr double kObjectSide = 44.0;
/// Cells around the object's box in a window.
inline constexpr int kWindowMargin = 2;

/// The look of a class of solid things within one range of shapes.
struct SolidModel {
  std::uint32_t object_class = 0;
  std::int32_t rows = 0;  ///< of the window, cells
  std::int32_t columns = 0;
  float zero = 0.0F;     ///< sum of the score 0: what clutter reaches in one picture of some
  float typical = 1.0F;  ///< sum of the score 0.5: half of the objects reach it
  BoostedTrees trees;

  float scoreOf(float sum) const { return 0.5F * (sum - zero) / (typical - zero); }
  std::size_t width() const { return static_cast<std::size_t>(rows * columns * kChannels); }
};

}  // namespace rubble::recognizer
