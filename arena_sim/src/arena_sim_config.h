#pragma once

#include "common/config.h"
#include "lidar_model.h"
#include "motion.h"
#include "odometry_model.h"

namespace rubble::arena_sim {

/// Section `arena_sim`.
struct ArenaSimConfig {
  LidarModelConfig lidar;
  OdometryModelConfig odometry;
  MotionLimits motion;
};

void visit(common::ConfigSection& section, ArenaSimConfig& config);

}  // namespace rubble::arena_sim
