#pragma once

#include "world/site.h"

namespace rubble::arena_sim {

/// The hall's inside. Frame `arena`.
struct HallSize {
  Eigen::Vector2d centre;
  Eigen::Vector3d size;
};

/// The hall's lamps under its ceiling and work lights on posts at the arena's outer walls. A lamp lights a
/// point with power * area * cos(at lamp) * cos(at surface) / distance^2; on the arena's floor all of it sums
/// up to about 1.
void addLights(Site& site, const HallSize& hall, Random& random);

}  // namespace rubble::arena_sim
