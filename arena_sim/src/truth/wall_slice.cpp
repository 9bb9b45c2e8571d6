#include "truth/wall_slice.h"

#include <Eigen/Core>

namespace rubble::arena_sim {

std::vector<Segment> sliceAt(const Scene& scene, double z) {
  std::vector<Segment> slice;
  for (const Surface& surface : scene.surfaces) {
    for (const auto& triangle : surface.triangles) {
      // A corner exactly in the plane counts as above it, so that neighbours agree.
      std::vector<Eigen::Vector2d> crossings;
      for (std::size_t i = 0; i < 3; ++i) {
        const Eigen::Vector3d a = surface.vertices[triangle[i]].p_world.cast<double>();
        const Eigen::Vector3d b = surface.vertices[triangle[(i + 1) % 3]].p_world.cast<double>();
        if ((a.z() >= z) != (b.z() >= z)) {
          crossings.emplace_back((a + (z - a.z()) / (b.z() - a.z()) * (b - a)).head<2>());
        }
      }
      if (crossings.size() == 2) {
        slice.push_back({crossings[0], crossings[1]});
      }
    }
  }
  return slice;
}

}  // namespace rubble::arena_sim
