#pragma once

#include "arena_sim/mission.h"
#include "common/config.h"

namespace rubble::tools {

/// A mission that is made within seconds: few and small pictures.
inline arena_sim::MissionOptions smallMission() {
  arena_sim::MissionOptions options;
  options.duration_s = arena_sim::kShortestMission;
  return options;
}

inline common::Config smallArena() {
  common::Config config;
  for (const char* assignment :
       {"arena_sim.picture_scale=0.25", "arena_sim.camera.samples=1", "robot.camera.rate=5",
        "arena_sim.camera.texture_budget=0.5", "arena_sim.lidar.beams=271", "arena_sim.lidar.rate=20"}) {
    config.addOverride(assignment);
  }
  return config;
}

}  // namespace rubble::tools
