#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/geometry.h"
#include "scene/scene.h"

// Surfaces of rounded solids, with smooth normals.
namespace rubble::arena_sim {

/// An ellipsoid about the origin of T_world_part. Its chart is a map of the globe: the pole +z on top, +x in
/// the middle, +y to the right of it.
Surface makeEllipsoid(const common::Pose3& T_world_part, const Eigen::Vector3d& radii,
                      const Appearance& appearance);

/// A limb between two joints with ball-shaped ends, thicker at one of them.
Surface makeLimb(const Eigen::Vector3d& from_world, const Eigen::Vector3d& to_world, double from_radius,
                 double to_radius, const Appearance& appearance);

}  // namespace rubble::arena_sim
