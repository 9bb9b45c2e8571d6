#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace rubble::arena_sim {

/// An object of a mission and how its camera saw it.
struct Sighting {
  std::string id;  // This and the next four as in truth/objects.csv.
  std::string object_class;
  std::string kind;
  std::string text;
  Eigen::Vector3d p_world;
  /// Its size (pixels) in every picture in which it was in plain sight: all of it in the picture, not too
  /// much from the side, hardly anything before it. A picture's size is the geometric mean of its outline's
  /// four sides; a victim's that of width and height of what its box covers.
  std::vector<double> sizes;
};

/// By geometry: of what disturbances did to the pictures nothing is known. `mission`: a folder that
/// writeMission() wrote; its world is built again, without a seed by trying those below 1000. Throws
/// common::Error.
std::vector<Sighting> findSightings(const std::filesystem::path& mission, std::optional<std::uint64_t> seed);

}  // namespace rubble::arena_sim
