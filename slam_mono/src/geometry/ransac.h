#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>

namespace rubble::slam_mono {

/// In [0, n), n < 2^32; the same on every platform, unlike std::uniform_int_distribution.
inline std::size_t randomIndex(std::mt19937_64& random, std::size_t n) {
  return static_cast<std::size_t>(((random() >> 32U) * static_cast<std::uint64_t>(n)) >> 32U);
}

/// N different indices below n >= N.
template <std::size_t N>
std::array<std::size_t, N> randomSample(std::mt19937_64& random, std::size_t n) {
  std::array<std::size_t, N> sample{};
  for (auto end = sample.begin(); end != sample.end();) {
    *end = randomIndex(random, n);
    end += std::find(sample.begin(), end, *end) == end ? 1 : 0;
  }
  return sample;
}

/// Iterations after which a clean sample was drawn with probability 0.999 (Fischler & Bolles 1981), at most
/// `most`.
inline int ransacIterations(double inlier_share, int sample_size, int most) {
  const double clean = std::pow(inlier_share, sample_size);
  if (clean > 0.999) {
    return std::min(1, most);
  }
  const double needed = std::log(0.001) / std::log1p(-std::max(clean, 1e-12));
  return needed < most ? static_cast<int>(std::ceil(needed)) : most;
}

}  // namespace rubble::slam_mono
