#pragma once

#include <random>

#include "common/config.h"
#include "sensors/pose_at.h"
#include "sensors/stabilizer_model.h"

namespace rubble::arena_sim {

/// Units in visit().
struct PlateControllerConfig {
  double rate = 50.0;
  double delay = 0.05;
  double attitude_sigma = 0.005;
  double rate_sigma = 0.05;
};

void visit(common::ConfigSection& section, PlateControllerConfig& config);

/// Levels the plate in a recorded mission, where no fusion runs: what fusion would command if it knew the
/// true attitude late and with noise.
class PlateController {
 public:
  PlateController(const PlateControllerConfig& config, PoseAt T_world_body, std::mt19937_64 random);

  PlateCommand next(double seconds);

 private:
  const PlateControllerConfig config_;
  const PoseAt T_world_body_;
  std::mt19937_64 random_;
};

}  // namespace rubble::arena_sim
