#pragma once

#include <memory>
#include <string>

#include "common/config.h"
#include "lcm_io/node.h"
#include "lcm_io/process.h"

namespace rubble::slam_mono {

/// The process rubble-slam-mono between the bus and MonoSlam: CAMERA (with the calibration from CAMERA_INFO,
/// else from section robot.camera) to MONO_FEATURES, MONO_POSE and MONO_MAP. Throws common::Error for a bad
/// configuration.
std::unique_ptr<lcm_io::Node> makeNode(const lcm_io::ProcessContext& context);

/// The effective `robot` and `slam_mono` sections as commented YAML. Throws common::Error like makeNode.
std::string describeConfig(const common::Config& config);

}  // namespace rubble::slam_mono
