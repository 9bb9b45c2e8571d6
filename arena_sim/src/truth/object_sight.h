#pragma once

#include <optional>

#include "common/robot_config.h"
#include "scene/ray_tracer.h"
#include "sensors/lens.h"
#include "world/world.h"

namespace rubble::arena_sim {

/// When an object is in plain sight of a camera, and how large it then is.
class ObjectSight {
 public:
  /// Throws common::Error for a lens that cannot be inverted.
  ObjectSight(const Scene& scene, const common::RobotConfig::Intrinsics& intrinsics);

  /// Pixels: the geometric mean of the four sides of a picture's outline, or of width and height of what a
  /// victim's box covers. Empty unless all corners are in the picture, a picture is seen at 70 degrees from
  /// its normal or less, and little stands before it: 90 % of a grid of rays reach a picture, 60 % a victim.
  std::optional<double> sizeOf(const WorldObject& object, const common::Pose3& T_world_camera) const;

 private:
  std::optional<Eigen::Vector2d> pixelOf(const Eigen::Vector3d& p_camera) const;
  double freeShare(const WorldObject& object, const Eigen::Vector3d& p_world_camera) const;

  const common::RobotConfig::Intrinsics intrinsics_;
  const Lens lens_;
  const RayTracer tracer_;
};

}  // namespace rubble::arena_sim
