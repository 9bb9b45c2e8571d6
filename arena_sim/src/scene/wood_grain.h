#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "scene/noise.h"

namespace rubble::arena_sim {

struct Knot {
  cv::Point2f place;    // m
  float radius = 0.0F;  // m, of the dark heart; the grain bends around it.
};

/// Grain running along u: a slanted cut through a tree's rings, whose lines are the contours of a wavy
/// height.
class WoodGrain {
 public:
  struct Shape {
    float ring = 0.012F;         // m, between two rings where the cut is even.
    float waviness = 2.0F;       // Rings by which the cut wanders.
    float wave_length = 0.9F;    // m, along u.
    float ring_contrast = 9.0F;  // Grey levels.
    float fibre_contrast = 5.0F;
  };

  WoodGrain(std::uint64_t seed, float pixel, const Shape& shape);

  /// Rings by which the cut of row y is offset, for piece(): to be called once per row first.
  void startRow(int y, std::size_t columns);

  /// Adds the tones of one piece of wood in the texels [begin, end) of the row; `offset` (rings) tells pieces
  /// apart. Knots are those of the piece.
  void piece(std::size_t begin, std::size_t end, float v, float offset, std::span<const Knot> knots,
             std::span<float> tones);

 private:
  void bendAround(const Knot& knot, float v, std::size_t begin, std::size_t end);

  Shape shape_;
  float pixel_;
  Fractal waves_;
  Fractal fibres_;
  std::vector<float> profile_;  // Tone over the rings.
  std::vector<float> wave_row_;
  std::vector<float> fibre_row_;
  std::vector<float> knot_row_;
};

}  // namespace rubble::arena_sim
