#include "sensors/ray_table.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace rubble::arena_sim {

namespace {

int roundUp(int value, int step) { return (value + step - 1) / step * step; }

float fraction(double value) { return std::min(static_cast<float>(value - std::floor(value)), 0.99999F); }

}  // namespace

RayTable::RayTable(const Lens& lens, int width, int height)
    : stride(static_cast<std::size_t>(roundUp(width, kGroup) + 1)) {
  const auto columns = static_cast<int>(stride);
  const int rows = roundUp(height, 2) + 1;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const Eigen::Vector3d ray =
          lens.unproject({std::min(column, width) - 0.5, std::min(row, height) - 0.5});
      x.push_back(static_cast<float>(ray.x()));
      y.push_back(static_cast<float>(ray.y()));
      z.push_back(static_cast<float>(ray.z()));
    }
  }
  const auto at = [&](std::size_t i) { return Eigen::Vector3f(x[i], y[i], z[i]); };
  for (std::size_t i = 0; i < x.size(); ++i) {
    const std::size_t right = std::min(i + 1, x.size() - 1);
    const std::size_t below = std::min(i + stride, x.size() - 1);
    constexpr float kSmallest = 1e-12F;  // In the padding.
    log2_area.push_back(std::log2(std::max(kSmallest, (at(right) - at(i)).cross(at(below) - at(i)).norm())));
  }
}

/// Roberts' R2 sequence (2018), in every pixel from another place on.
SamplePattern::SamplePattern(int samples) : tiles(samples) {
  constexpr double kStepX = 0.7548776662466927;
  constexpr double kStepY = 0.5698402909980532;
  for (int i = 0; i < kSide * kSide; ++i) {
    const auto uniform = [&](unsigned dimension) {
      constexpr double kUnit = 0x1p-53;
      return static_cast<double>(hashOf(hashOf(i) + dimension) >> 11U) * kUnit;
    };
    for (int s = 0; s < samples; ++s) {
      Tile& tile = tiles[s];
      tile.x.push_back(fraction(uniform(0) + s * kStepX));
      tile.y.push_back(fraction(uniform(1) + s * kStepY));
      tile.time.push_back(fraction(uniform(4 + s)));
      tile.level.push_back(fraction(uniform(2) + static_cast<double>(s) / samples));
    }
  }
}

/// Splitmix64 (Steele, Lea and Flood, OOPSLA 2014).
std::uint64_t hashOf(std::uint64_t value) {
  value += 0x9e3779b97f4a7c15U;
  value = (value ^ (value >> 30U)) * 0xbf58476d1ce4e5b9U;
  value = (value ^ (value >> 27U)) * 0x94d049bb133111ebU;
  return value ^ (value >> 31U);
}

}  // namespace rubble::arena_sim
