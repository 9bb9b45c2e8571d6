#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "geometry/sim3.h"

namespace rubble::slam_mono {

/// A measured similarity between two vertices: S_a_b.
struct PoseGraphEdge {
  std::size_t a = 0;
  std::size_t b = 0;
  Sim3 S_a_b;
};

/// Moves the vertices S_camera_mono so that they agree best with the edges (Strasdat, Montiel, Davison:
/// "Scale drift-aware large scale monocular SLAM", RSS 2010), vertex `fixed` held.
void optimizePoseGraph(std::vector<Sim3>& S_camera_mono, std::span<const PoseGraphEdge> edges,
                       std::size_t fixed);

}  // namespace rubble::slam_mono
