#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <random>
#include <vector>

namespace rubble::arena_sim {

/// A straight piece of wall, infinitely thin, at the LiDAR's height. Metres, frame `world`.
struct Segment {
  Eigen::Vector2d a;
  Eigen::Vector2d b;
};

double distanceTo(const Segment& segment, const Eigen::Vector2d& p);

/// Convex, counter-clockwise corners.
using Polygon = std::vector<Eigen::Vector2d>;

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
