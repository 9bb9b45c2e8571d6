#pragma once

#include <opencv2/core.hpp>

#include "scene/scene.h"

namespace rubble::arena_sim {

/// Paints a surface's chart of `size` (m): 8UC3 BGR, first row at the largest v, square pixels of about
/// `pixel` m. A value v stands for the reflectance (v / 255)^2. Natural and different for every seed; the
/// same arguments give the same picture.
cv::Mat paintMaterial(Material material, std::uint64_t seed, const cv::Size2f& size, float pixel);

/// Share of light at the LiDAR's 905 nm that the material throws back, 0 .. 1.
double reflectivityAt905nm(Material material);

}  // namespace rubble::arena_sim
