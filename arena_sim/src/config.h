#pragma once

#include <vector>

#include "common/config.h"
#include "disturbances.h"
#include "motion/route.h"
#include "sensors/camera_model.h"
#include "sensors/lidar_model.h"
#include "sensors/odometry_model.h"
#include "sensors/plate_controller.h"
#include "sensors/stabilizer_model.h"
#include "truth/truth_recorder.h"
#include "world/world.h"

namespace rubble::arena_sim {

/// Section `arena_sim`: a scenario.
struct ArenaSimConfig {
  WorldConfig world;
  MotionConfig motion;
  CameraModelConfig camera;
  double picture_scale = 1.0;
  LidarModelConfig lidar;
  StabilizerModelConfig stabilizer;
  PlateControllerConfig plate_controller;
  OdometryModelConfig odometry;
  TruthConfig truth;
  std::vector<Disturbance> disturbances;
};

void visit(common::ConfigSection& section, ArenaSimConfig& config);

}  // namespace rubble::arena_sim
