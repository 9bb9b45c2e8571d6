#pragma once

#include <memory>
#include <string>

#include "common/config.h"
#include "lcm_io/node.h"
#include "lcm_io/process.h"

namespace rubble::fusion {

/// The process rubble-fusion between the bus and PoseFusion: MONO_POSE, MONO_MAP, LIDAR_POSE and STABILIZER
/// to ROBOT_POSE, FUSION_STATE, LIDAR_CONTROL and STABILIZER_COMMAND; DETECTIONS and MONO_FEATURES to
/// OBJECTS. Passive until the first MONO_POSE. Throws common::Error for a bad configuration.
std::unique_ptr<lcm_io::Node> makeNode(const lcm_io::ProcessContext& context);

/// The effective `fusion` and `robot` sections as commented YAML. Throws common::Error like makeNode.
std::string describeConfig(const common::Config& config);

}  // namespace rubble::fusion
