#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "sensors/lens.h"

namespace rubble::arena_sim {

/// Rays through the corners of all pixels (unit, optical frame), padded so that groups of kGroup pixels and
/// pairs of rows may hang over the picture's edge. Inside a pixel they are interpolated, to 0.001 pixels.
struct RayTable {
  static constexpr int kGroup = 4;

  RayTable(const Lens& lens, int width, int height);

  std::size_t stride = 0;
  std::vector<float> x;  // By corner; the first is that of the first pixel, at (-0.5, -0.5).
  std::vector<float> y;
  std::vector<float> z;
  std::vector<float> log2_area;  // Of the pixel right and below: its solid angle, sr.
};

/// Where in its pixel and when in its exposure a sample lies: evenly spread for every pixel, differently for
/// neighbours. Tiles of kSide^2 pixels, all values in [0, 1).
struct SamplePattern {
  static constexpr int kSide = 32;

  explicit SamplePattern(int samples);

  struct Tile {
    std::vector<float> x;
    std::vector<float> y;
    std::vector<float> time;  // Within the sample's part of the exposure.
    std::vector<float> level;
  };
  std::vector<Tile> tiles;  // By sample.
};

/// Mixes the bits of a number well.
std::uint64_t hashOf(std::uint64_t value);

}  // namespace rubble::arena_sim
