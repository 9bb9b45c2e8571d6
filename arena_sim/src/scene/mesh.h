#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "common/geometry.h"
#include "scene/scene.h"

// Surfaces of simple solids. Every face has a chart and a seed of its own, so that no texture repeats.
namespace rubble::arena_sim {

/// Light is kept per vertex, so faces are cut into cells of at most this size (m) unless said otherwise.
inline constexpr float kMeshCell = 0.15F;

/// A convex flat polygon with corners counter-clockwise seen from outside. u runs along the first edge.
Surface makePolygon(std::span<const Eigen::Vector3d> corners, const Appearance& appearance,
                    float cell = kMeshCell);

/// A picture of `size` (m) in the x-y plane of T_world_picture, centred there, facing +z.
Surface makePicture(const common::Pose3& T_world_picture, const Eigen::Vector2d& size,
                    const Appearance& appearance, float cell = kMeshCell);

/// The solid over a convex, counter-clockwise ground outline between `bottom` and the heights `top` (one per
/// corner, all in one plane): boxes, ramps and walls. Without its underside. Appends to `surfaces`; faces
/// take seeds of their own from appearance.seed.
void addPrism(std::vector<Surface>& surfaces, std::span<const Eigen::Vector2d> outline, double bottom,
              std::span<const double> top, const Appearance& appearance, bool drivable,
              float cell = kMeshCell);

/// A box of `size` (x, y, z), all six faces, its centre at T_world_box.
void addBox(std::vector<Surface>& surfaces, const common::Pose3& T_world_box, const Eigen::Vector3d& size,
            const Appearance& appearance, bool drivable, float cell = kMeshCell);

}  // namespace rubble::arena_sim
