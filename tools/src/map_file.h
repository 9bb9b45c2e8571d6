#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <vector>

namespace rubble::tools {

/// Centres of the occupied cells of a map in ROS map_server's form, m in the map's frame. The YAML names
/// image (any that OpenCV reads, relative to the YAML), resolution, origin [x, y, yaw] of the lower left
/// pixel, negate, occupied_thresh. Throws Error naming the file and what is wrong with it.
std::vector<Eigen::Vector2d> readOccupiedCells(const std::filesystem::path& yaml);

}  // namespace rubble::tools
