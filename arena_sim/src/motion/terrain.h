#pragma once

#include <Eigen/Core>
#include <limits>
#include <vector>

#include "scene/ray_tracer.h"
#include "world/world.h"

namespace rubble::arena_sim {

/// The ground under the tracks: the highest drivable surface. Frame `world`.
class Terrain {
 public:
  static constexpr double kNoGround = -std::numeric_limits<double>::infinity();

  /// Tracks cannot reach through the barriers.
  Terrain(const Scene& scene, const std::vector<Segment>& barriers);

  /// m; kNoGround where there is nothing to drive on.
  double height(const Eigen::Vector2d& p) const;

  /// The same for the part at p of a robot at `centre`; kNoGround behind a barrier.
  double heightFrom(const Eigen::Vector2d& centre, const Eigen::Vector2d& p) const;

 private:
  struct Barrier {
    Segment line;
    Eigen::Vector2d middle;
    double reach = 0.0;  // From the middle to where a robot may feel it.
  };

  RayTracer tracer_;
  std::vector<Barrier> barriers_;
};

/// All that stops a robot on its ways, those over the crossing included.
std::vector<Segment> barriersOf(const World& world);

}  // namespace rubble::arena_sim
