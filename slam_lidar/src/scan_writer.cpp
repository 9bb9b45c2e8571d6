#include "scan_writer.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

namespace rubble::slam_lidar {
namespace {

constexpr double kSurfaceGap = 0.4;  // metres

int logOdds(double probability) {
  return static_cast<int>(std::lround(kLogOddsScale * std::log(probability / (1.0 - probability))));
}

}  // namespace

ScanWriter::ScanWriter(const GridSlamConfig& config)
    : hit_(logOdds(config.map.hit_probability)),
      miss_(logOdds(config.map.miss_probability)),
      limit_(static_cast<int>(std::lround(kLogOddsScale * config.map.max_log_odds))),
      free_space_range_(config.scan.free_space_range) {}

void ScanWriter::traceFree(TiledGrid& grid, const Eigen::Vector2i& from, const Eigen::Vector2i& to) const {
  // Bresenham, the end cell excluded.
  const int dx = std::abs(to.x() - from.x());
  const int dy = std::abs(to.y() - from.y());
  const int step_x = from.x() < to.x() ? 1 : -1;
  const int step_y = from.y() < to.y() ? 1 : -1;
  int error = dx - dy;
  for (int x = from.x(), y = from.y(); x != to.x() || y != to.y();) {
    grid.addEvidence(x, y, miss_, limit_);
    const int twice = 2 * error;
    if (twice > -dy) {
      error -= dy;
      x += step_x;
    }
    if (twice < dx) {
      error += dx;
      y += step_y;
    }
  }
}

void ScanWriter::write(TiledGrid& grid, const common::Pose2& T_world_lidar, std::span<const RayEnd> rays,
                       std::uint64_t revision) {
  grid.beginScan(revision);
  const GridView view = grid.view();
  const Eigen::Vector2d origin = (T_world_lidar.translation() - view.p_world_window) / view.cell_size;
  const double c = std::cos(T_world_lidar.yaw) / view.cell_size;
  const double s = std::sin(T_world_lidar.yaw) / view.cell_size;
  const auto cellOf = [&](double x, double y) {
    return Eigen::Vector2i(static_cast<int>(origin.x() + c * x - s * y),
                           static_cast<int>(origin.y() + s * x + c * y));
  };
  const auto addHit = [&](const Eigen::Vector2d& p) {
    const Eigen::Vector2i cell = cellOf(p.x(), p.y());
    grid.addEvidence(cell.x(), cell.y(), hit_, limit_);
  };
  ends_.clear();
  Eigen::Vector2d previous = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
  for (const RayEnd& ray : rays) {
    const Eigen::Vector2d p(static_cast<double>(ray.x), static_cast<double>(ray.y));
    const double range = p.norm();
    const double free = std::min(1.0, free_space_range_ / range);
    ends_.push_back(cellOf(p.x() * free, p.y() * free));
    if (!ray.hit) {
      continue;
    }
    // Hits this close are one surface. Left apart they would be a comb, in which the next scan's hits catch,
    // so that the robot seems to stand still along the wall.
    const double gap = (p - previous).norm();
    if (gap < kSurfaceGap) {
      const int between = static_cast<int>(gap / view.cell_size);
      for (int k = 1; k <= between; ++k) {
        addHit(previous + (p - previous) * k / (between + 1));
      }
    }
    addHit(p);
    previous = p;
  }
  // Hits came first, so that a beam passing close to a hit does not take it back.
  const Eigen::Vector2i start = cellOf(0.0, 0.0);
  for (const Eigen::Vector2i& end : ends_) {
    traceFree(grid, start, end);
  }
}

}  // namespace rubble::slam_lidar
