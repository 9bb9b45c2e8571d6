#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <optional>

#include "motion/clearance_grid.h"
#include "sensors/camera_model.h"
#include "world/random.h"
#include "world/world.h"

namespace rubble::arena_sim {

/// Pictures that the arena's robot might take in a world, from free places on its ground, in motion.
class RobotViews {
 public:
  RobotViews(const World& world, std::uint64_t seed);

  /// T_world_camera: anywhere, looking anywhere.
  common::Pose3 anywhere();
  /// T_world_camera: `distance` m from an object, looking about there. Empty: it stands too close to walls.
  std::optional<common::Pose3> towards(const WorldObject& object, double distance);
  /// 8UC3 BGR.
  cv::Mat take(const common::Pose3& T_world_camera);

 private:
  common::Pose3 cameraAt(const Eigen::Vector2d& p, double yaw);

  const common::RobotConfig robot_;
  Random random_;
  const ClearanceGrid clearance_;
  const Eigen::AlignedBox2d bounds_;
  CameraModel camera_;
  double seconds_ = 0.0;
};

}  // namespace rubble::arena_sim
