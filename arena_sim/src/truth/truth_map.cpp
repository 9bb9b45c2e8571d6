#include "truth/truth_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/error.h"

namespace rubble::arena_sim {

namespace {

using Eigen::Vector2d;

constexpr double kMargin = 0.5;
constexpr double kWallSpacing = 0.2 * TruthMap::kCellSize;
constexpr double kBeamSpacing =
    0.6 * TruthMap::kCellSize;  // Beams are many: others fill the corner one misses.

/// Calls visit for points from a to b at most `spacing` apart.
template <typename Visit>
void sampleLine(const Vector2d& a, const Vector2d& b, double spacing, const Visit& visit) {
  const int steps = 1 + static_cast<int>((b - a).norm() / spacing);
  for (int i = 0; i <= steps; ++i) {
    visit(a + (b - a) * (static_cast<double>(i) / steps));
  }
}

}  // namespace

TruthMap::TruthMap(const std::vector<Segment>& walls) {
  const Eigen::AlignedBox2d bounds = boundsOf(walls);
  const Vector2d upper = bounds.max();
  lower_ = ((bounds.min().array() - kMargin) / kCellSize).floor() * kCellSize;
  width_ = static_cast<int>(std::ceil((upper.x() + kMargin - lower_.x()) / kCellSize));
  height_ = static_cast<int>(std::ceil((upper.y() + kMargin - lower_.y()) / kCellSize));
  const auto cells = static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
  is_wall_.resize(cells);
  is_hit_.resize(cells);
  is_free_.resize(cells);
  for (const Segment& wall : walls) {
    sampleLine(wall.a, wall.b, kWallSpacing, [&](const Vector2d& p) { is_wall_[indexOf(p)] = 1; });
  }
}

bool TruthMap::contains(const Vector2d& p) const {
  const Vector2d cell = (p - lower_) / kCellSize;
  return cell.x() >= 0.0 && cell.y() >= 0.0 && cell.x() < width_ && cell.y() < height_;
}

std::size_t TruthMap::indexOf(const Vector2d& p) const {
  RUBBLE_CHECK(contains(p));
  const int x = static_cast<int>((p.x() - lower_.x()) / kCellSize);
  const int y = static_cast<int>((p.y() - lower_.y()) / kCellSize);
  return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
}

void TruthMap::addBeam(const Vector2d& a, const Vector2d& b) {
  sampleLine(a, b, kBeamSpacing, [&](const Vector2d& p) { is_free_[indexOf(p)] = 1; });
  is_hit_[indexOf(b)] = 1;
}

std::uint8_t TruthMap::cell(int x, int y) const {
  const auto at = [&](int column, int row) {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) +
           static_cast<std::size_t>(column);
  };
  const std::size_t here = at(x, y);
  if (is_wall_[here] == 0) {
    return is_free_[here] != 0 ? kFree : kUnknown;
  }
  // The walls keep half a metre from the border, so every wall has all eight neighbours.
  for (int row = y - 1; row <= y + 1; ++row) {
    for (int column = x - 1; column <= x + 1; ++column) {
      if (is_hit_[at(column, row)] != 0) {
        return kOccupied;
      }
    }
  }
  return kUnknown;
}

std::string TruthMap::pgm() const {
  std::string text = fmt::format("P5\n{} {}\n255\n", width_, height_);
  for (int y = height_ - 1; y >= 0; --y) {
    for (int x = 0; x < width_; ++x) {
      text.push_back(static_cast<char>(cell(x, y)));
    }
  }
  return text;
}

std::string TruthMap::yaml(const std::string& pgm_name) const {
  return fmt::format(
      "image: {}\nresolution: {}\norigin: [{:.2f}, {:.2f}, 0.0]\nnegate: 0\noccupied_thresh: 0.65\n"
      "free_thresh: 0.196\n",
      pgm_name, kCellSize, lower_.x(), lower_.y());
}

}  // namespace rubble::arena_sim
