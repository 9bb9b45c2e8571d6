#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <filesystem>
#include <vector>

namespace rubble::tools {

/// A map of more is of no use and does not fit the memory.
inline constexpr std::int64_t kMostMapPixels = 400'000'000;

/// Centres of the occupied cells of a map in ROS map_server's form, m in the map's frame. The YAML names
/// image (PGM, PNG or JPEG, relative to the YAML), resolution, origin [x, y, yaw] of the lower left
/// pixel, negate, occupied_thresh. Throws Error naming the file and what is wrong with it.
std::vector<Eigen::Vector2d> readOccupiedCells(const std::filesystem::path& yaml);
/// Those in a box only.
std::vector<Eigen::Vector2d> readOccupiedCells(const std::filesystem::path& yaml,
                                               const Eigen::AlignedBox2d& box);

}  // namespace rubble::tools
