#include "scene/noise.h"

#include <algorithm>
#include <cmath>

namespace rubble::arena_sim {

namespace {

/// A B-spline averages: this makes up for it (uniform numbers of variance 1/3, 151/315 left per axis).
constexpr float kUnitVariance = 3.6132F;

}  // namespace

// Finalizers of MurmurHash3 and SplitMix64 (public domain constants).
std::uint32_t hashBits(std::uint64_t seed, int x, int y) {
  std::uint32_t h = static_cast<std::uint32_t>(seed) ^ static_cast<std::uint32_t>(seed >> 32U) * 0x9e3779b9U;
  h ^= static_cast<std::uint32_t>(x) * 0x85ebca6bU;
  h = (h ^ (h >> 15U)) * 0x2c1b3c6dU;
  h ^= static_cast<std::uint32_t>(y) * 0xc2b2ae35U;
  h = (h ^ (h >> 12U)) * 0x297a2d39U;
  return h ^ (h >> 15U);
}

float hashSigned(std::uint64_t seed, int x, int y) {
  return static_cast<float>(static_cast<std::int32_t>(hashBits(seed, x, y))) * 0x1p-31F;
}

std::uint64_t derivedSeed(std::uint64_t seed, std::uint64_t purpose) {
  std::uint64_t z = seed + (purpose + 1) * 0x9e3779b97f4a7c15U;
  z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9U;
  z = (z ^ (z >> 27U)) * 0x94d049bb133111ebU;
  return z ^ (z >> 31U);
}

NoiseLayer::NoiseLayer(std::uint64_t seed, float cell_x, float cell_y)
    : seed_(seed), cell_x_(std::max(cell_x, 1.0F)), cell_y_(std::max(cell_y, 1.0F)) {}

void NoiseLayer::fillLattice(int lattice_y, std::vector<float>& values) const {
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = hashSigned(seed_, static_cast<int>(i), lattice_y);
  }
}

void NoiseLayer::prepare(int lattice_y, std::size_t columns) {
  if (lattice_[0].size() == columns && lattice_y == first_row_) {
    return;
  }
  if (lattice_[0].size() == columns && lattice_y == first_row_ + 1) {
    std::rotate(lattice_.begin(), lattice_.begin() + 1, lattice_.end());
    fillLattice(lattice_y + 3, lattice_[3]);
  } else {
    for (int i = 0; i < 4; ++i) {
      lattice_[i].resize(columns);
      fillLattice(lattice_y + i, lattice_[i]);
    }
    blended_.resize(columns);
  }
  first_row_ = lattice_y;
}

void NoiseLayer::addRow(int y, float gain, std::span<float> row) {
  const float place = static_cast<float>(y) / cell_y_;
  const auto lattice_y = static_cast<int>(std::floor(place));
  const float s = place - static_cast<float>(lattice_y);
  const float inverse = 1.0F / cell_x_;
  const auto cells = static_cast<std::size_t>(static_cast<float>(row.size()) * inverse) + 2;
  prepare(lattice_y, cells + 3);

  const float w0 = (1.0F - s) * (1.0F - s) * (1.0F - s) / 6.0F;
  const float w1 = (4.0F - 6.0F * s * s + 3.0F * s * s * s) / 6.0F;
  const float w3 = s * s * s / 6.0F;
  const float w2 = 1.0F - w0 - w1 - w3;
  const float scale = gain * kUnitVariance;
  for (std::size_t i = 0; i < blended_.size(); ++i) {
    blended_[i] =
        scale * (w0 * lattice_[0][i] + w1 * lattice_[1][i] + w2 * lattice_[2][i] + w3 * lattice_[3][i]);
  }

  const auto size = static_cast<int>(row.size());
  float* const out = row.data();
  int x = 0;
  for (int cell = 0; x < size; ++cell) {
    const float* p = &blended_[std::min(static_cast<std::size_t>(cell), cells - 1)];
    const float a = (p[0] + 4.0F * p[1] + p[2]) * (1.0F / 6.0F);
    const float b = 0.5F * (p[2] - p[0]);
    const float c = 0.5F * (p[0] - 2.0F * p[1] + p[2]);
    const float d = (p[3] - p[0]) * (1.0F / 6.0F) + 0.5F * (p[1] - p[2]);
    const int end = std::min(size, static_cast<int>(static_cast<float>(cell + 1) * cell_x_) + 1);
    const auto begin = static_cast<float>(cell);
    for (; x < end; ++x) {
      const float t = static_cast<float>(x) * inverse - begin;
      out[x] += a + t * (b + t * (c + t * d));
    }
  }
}

Fractal::Fractal(std::uint64_t seed, float pixel, float cell_u, float cell_v, int octaves,
                 float persistence) {
  float gain = 1.0F;
  float power = 0.0F;
  for (int i = 0; i < octaves; ++i) {
    power += gain * gain;
    if (std::max(cell_u, cell_v) >= pixel) {
      layers_.emplace_back(derivedSeed(seed, static_cast<std::uint64_t>(i)), cell_u / pixel, cell_v / pixel);
      gains_.push_back(gain);
    }
    gain *= persistence;
    cell_u *= 0.5F;
    cell_v *= 0.5F;
  }
  for (float& g : gains_) {
    g /= std::sqrt(power);
  }
}

void Fractal::addRow(int y, float gain, std::span<float> row) {
  for (std::size_t i = 0; i < layers_.size(); ++i) {
    layers_[i].addRow(y, gain * gains_[i], row);
  }
}

}  // namespace rubble::arena_sim
