#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "synthetic_world.h"

namespace rubble::slam_mono {

/// A world and the line through it that a robot may follow.
struct SyntheticScene {
  SyntheticWorld world;
  std::vector<Eigen::Vector2d> line;
  bool closed = false;  ///< the line ends where it begins
};

/// 10 x 8 m around the origin with inner walls in the middle; the line goes round them, 23 m.
SyntheticScene makeRoom(std::uint64_t seed);
/// Corridor 2 m wide along a rectangle of 60 m.
SyntheticScene makeRing(std::uint64_t seed);
/// Corridors 2 m wide one after the other, never the same place twice. Their doors (about a quarter of the
/// landmarks) are identical, all the rest is made of the same few patterns. In even seeds the doors' spacing
/// is the same everywhere, too.
SyntheticScene makeLookAlike(std::uint64_t seed);

}  // namespace rubble::slam_mono
