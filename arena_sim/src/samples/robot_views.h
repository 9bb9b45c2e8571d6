#pragma once

#include <functional>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>

#include "motion/clearance_grid.h"
#include "sensors/camera_model.h"
#include "world/random.h"
#include "world/world.h"

namespace rubble::arena_sim {

/// Of a surface's vertices, in world.
Eigen::Vector3d middleOf(const Surface& surface);

/// Pictures that the arena's robot might take in a world, from free places on its ground, in motion.
class RobotViews {
 public:
  RobotViews(const World& world, std::uint64_t seed);

  /// T_world_camera: anywhere, looking anywhere.
  common::Pose3 anywhere();
  /// T_world_camera: `distance` m from an object, looking about there. Empty: it stands too close to walls.
  std::optional<common::Pose3> towards(const WorldObject& object, double distance);
  /// T_world_camera: `distance` m from a flat picture in the world, before its front.
  std::optional<common::Pose3> before(const Surface& picture, double distance);
  /// 8UC3 BGR.
  cv::Mat take(const common::Pose3& T_world_camera);

 private:
  /// T_world_camera: looking about at `target`. `direction_at`: from there to the robot, by an angle.
  std::optional<common::Pose3> around(const Eigen::Vector3d& target, double distance,
                                      const std::function<Eigen::Vector3d(double side)>& direction_at);
  common::Pose3 cameraAt(const Eigen::Vector2d& p, double yaw);

  const common::RobotConfig robot_;
  Random random_;
  const ClearanceGrid clearance_;
  const Eigen::AlignedBox2d bounds_;
  CameraModel camera_;
  double seconds_ = 0.0;
};

}  // namespace rubble::arena_sim
