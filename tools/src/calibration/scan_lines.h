#pragma once

#include <Eigen/Core>
#include <vector>

namespace rubble::calibration {

/// One turn of a 2D LiDAR: beam i at angle_min + i * angle_step, counter-clockwise from x. Radians, metres;
/// a range that is not finite is none.
struct Scan {
  double angle_min = 0.0;
  double angle_step = 0.0;
  std::vector<double> ranges;

  std::vector<Eigen::Vector2d> points() const;
};

/// A straight run of a scan's points, in frame lidar (z = 0).
struct ScanLine {
  /// The same fit as all its points: to any line or plane these two have the points' mean square distance, up
  /// to what is across the run.
  Eigen::Vector2d first;
  Eigen::Vector2d second;
  double length = 0.0;  // m

  Eigen::Vector2d middle() const { return 0.5 * (first + second); }
};

/// All straight runs: the scan cut at jumps in range, then where it bends (Douglas-Peucker), without the
/// outermost points, which may lie half on something else.
std::vector<ScanLine> straightRuns(const Scan& scan);

}  // namespace rubble::calibration
