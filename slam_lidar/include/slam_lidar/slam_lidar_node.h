#pragma once

#include <memory>
#include <string>

#include "common/config.h"
#include "lcm_io/node.h"
#include "lcm_io/process.h"

namespace rubble::slam_lidar {

/// The process rubble-slam-lidar between the bus and GridSlam: SCAN (with STABILIZER, ROBOT_POSE's tilt,
/// ODOMETRY as optional motion prior, LIDAR_CONTROL) to LIDAR_POSE and GRID_MAP. Restores a fresh checkpoint
/// from context.state_dir. Throws common::Error for a bad configuration.
std::unique_ptr<lcm_io::Node> makeNode(const lcm_io::ProcessContext& context);

/// The effective `slam_lidar` and `robot` sections as commented YAML. Throws common::Error like makeNode.
std::string describeConfig(const common::Config& config);

}  // namespace rubble::slam_lidar
