#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

// Random fields for the painters: functions of seed and place only, so that every picture can be made again.
namespace rubble::arena_sim {

/// Well mixed bits of a lattice point.
std::uint32_t hashBits(std::uint64_t seed, int x, int y);

/// Even in [-1, 1).
float hashSigned(std::uint64_t seed, int x, int y);

/// Another seed for another purpose.
std::uint64_t derivedSeed(std::uint64_t seed, std::uint64_t purpose);

/// Smooth noise of one scale and unit variance: a lattice of random numbers under a cubic B-spline. Cheapest
/// when rows are asked for from top to bottom.
class NoiseLayer {
 public:
  /// The lattice's cells in texels, at least 1.
  NoiseLayer(std::uint64_t seed, float cell_x, float cell_y);

  /// Adds gain times the noise of row y.
  void addRow(int y, float gain, std::span<float> row);

 private:
  void fillLattice(int lattice_y, std::vector<float>& values) const;
  void prepare(int lattice_y, std::size_t columns);

  std::uint64_t seed_;
  float cell_x_;
  float cell_y_;
  int first_row_ = 0;
  std::array<std::vector<float>, 4> lattice_;  // Rows first_row_ .. first_row_ + 3.
  std::vector<float> blended_;
};

/// Noise layers of halving scales. Its variance is 1 when all scales are at least a texel wide; finer ones
/// are left out, as a camera that far away would average them away.
class Fractal {
 public:
  /// Coarsest cells and texels in m; every octave's gain is `persistence` times that of the one before.
  Fractal(std::uint64_t seed, float pixel, float cell_u, float cell_v, int octaves, float persistence);

  /// Adds gain times the noise of row y.
  void addRow(int y, float gain, std::span<float> row);

 private:
  std::vector<NoiseLayer> layers_;
  std::vector<float> gains_;
};

}  // namespace rubble::arena_sim
