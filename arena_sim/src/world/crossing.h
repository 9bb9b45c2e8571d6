#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/geometry.h"
#include "world/polygon.h"
#include "world/random.h"
#include "world/world.h"

namespace rubble::arena_sim {

struct Site;

/// Measures of the block with ramp, stairs and platform. Frame `block`: x from its front edge towards the
/// platform, y across, z up; the longer of ramp and stairs begins at x = 0.
struct CrossingPlan {
  static constexpr double kBoard = 0.04;  // Thickness of its walls.

  common::Pose2 T_arena_block;
  double height = 0.0;
  double ramp_angle = 0.0;  // rad
  int steps = 0;            // Risers, the last one up to the platform.
  double tread = 0.0;
  double platform_depth = 0.0;
  double lane = 0.0;  // Width of ramp and of stairs.
  bool ramp_at_low_y = true;

  double rampLength() const;
  double stairsLength() const { return (steps - 1) * tread; }
  double stairsAngle() const;
  /// x where the platform begins.
  double rise() const;
  double length() const { return rise() + platform_depth + kBoard; }
  double width() const { return 2.0 * lane + 3.0 * kBoard; }
  double rampY() const { return ramp_at_low_y ? lowY() : highY(); }
  double stairsY() const { return ramp_at_low_y ? highY() : lowY(); }
  double rampHeight(double x) const;
  double stairsHeight(double x) const;

 private:
  double lowY() const { return kBoard + 0.5 * lane; }
  double highY() const { return 2.0 * kBoard + 1.5 * lane; }
};

/// Without its place. Throws common::Error for a ramp that is too steep.
CrossingPlan drawCrossing(const WorldConfig& config, Random& random);

/// Where the way over the crossing begins and ends: this far in front of the block.
inline constexpr double kCrossingApproach = 1.05;

/// Surfaces and obstacles of the block.
void buildCrossing(Site& site, Random& random);

/// In frame `arena`.
Crossing describeCrossing(const CrossingPlan& plan);

}  // namespace rubble::arena_sim
