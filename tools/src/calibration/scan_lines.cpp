#include "calibration/scan_lines.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <span>

namespace rubble::calibration {

namespace {

constexpr double kJump = 0.1;        // m, along the beam: another thing
constexpr double kBend = 0.04;       // m across: twice the noise of a small LiDAR
constexpr std::size_t kFewest = 10;  // points of a run, with the two at its ends
constexpr double kShortest = 0.15;   // m

using Points = std::span<const Eigen::Vector2d>;

Eigen::Vector2d pointOf(const Scan& scan, std::size_t beam) {
  const double angle = scan.angle_min + static_cast<double>(beam) * scan.angle_step;
  return scan.ranges[beam] * Eigen::Vector2d(std::cos(angle), std::sin(angle));
}

void addRun(Points points, std::vector<ScanLine>& lines) {
  if (points.size() < kFewest) {
    return;
  }
  points = points.subspan(1, points.size() - 2);
  ScanLine line;
  const auto n = static_cast<double>(points.size());
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& p : points) {
    mean += p / n;
  }
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  for (const Eigen::Vector2d& p : points) {
    spread += (p - mean) * (p - mean).transpose() / n;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(spread);
  const Eigen::Vector2d along = axes.eigenvectors().col(1) * std::sqrt(axes.eigenvalues()(1));
  line.first = mean - along;
  line.second = mean + along;
  line.length = (points.back() - points.front()).norm();
  if (line.length >= kShortest) {
    lines.push_back(std::move(line));
  }
}

void cutAtBends(Points points, std::vector<ScanLine>& lines) {
  if (points.size() < kFewest) {
    return;
  }
  const Eigen::Vector2d along = (points.back() - points.front()).normalized();
  const Eigen::Vector2d across(-along.y(), along.x());
  std::size_t farthest = 0;
  double largest = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double off = std::abs(across.dot(points[i] - points.front()));
    if (off > largest) {
      largest = off;
      farthest = i;
    }
  }
  if (largest <= kBend) {
    addRun(points, lines);
    return;
  }
  cutAtBends(points.first(farthest + 1), lines);
  cutAtBends(points.subspan(farthest), lines);
}

}  // namespace

std::vector<Eigen::Vector2d> Scan::points() const {
  std::vector<Eigen::Vector2d> points;
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    if (std::isfinite(ranges[i])) {
      points.push_back(pointOf(*this, i));
    }
  }
  return points;
}

std::vector<ScanLine> straightRuns(const Scan& scan) {
  std::vector<ScanLine> lines;
  std::vector<Eigen::Vector2d> run;
  double last = 0.0;
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    const double range = scan.ranges[i];
    if (!std::isfinite(range) || std::abs(range - last) > kJump) {
      cutAtBends(run, lines);
      run.clear();
    }
    if (std::isfinite(range)) {
      run.push_back(pointOf(scan, i));
    }
    last = range;
  }
  cutAtBends(run, lines);
  return lines;
}

}  // namespace rubble::calibration
