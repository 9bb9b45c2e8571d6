#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <random>
#include <vector>

#include "polygon.h"

namespace rubble::arena_sim {

/// One level of rooms behind a closed outer wall, about 12 x 9 m. The frame is `world`: the robot starts at
/// the origin, heading along x, with at least kStartClearance to every wall.
struct Arena {
  std::vector<Segment> segments;
  std::vector<Polygon> rooms;
  std::vector<Eigen::Vector2d> doors;
  std::size_t start_room = 0;
};

inline constexpr double kStartClearance = 0.6;

/// Rooms by recursive division with straight or slanted walls, a door or two in every one, boxes and
/// cylinders. The same seed gives the same arena.
Arena makeArena(std::uint64_t seed);

/// Independent random numbers for one purpose (`stream`) of one mission.
std::mt19937_64 randomStream(std::uint64_t seed, std::uint32_t stream);

}  // namespace rubble::arena_sim
