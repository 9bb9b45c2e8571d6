#pragma once

#include <memory>
#include <string>

#include "common/config.h"
#include "lcm_io/node.h"
#include "lcm_io/process.h"

namespace rubble::recognizer {

/// The process rubble-recognizer: MONO_FEATURES and CAMERA to DETECTIONS and OBJECT_NOTICE (Chen et al. 2017,
/// section III-C). Passive until the first picture with its features. Throws common::Error for a bad
/// configuration or a vocabulary that cannot be loaded.
std::unique_ptr<lcm_io::Node> makeNode(const lcm_io::ProcessContext& context);

/// The effective `recognizer` section as commented YAML. Throws common::Error like makeNode.
std::string describeConfig(const common::Config& config);

}  // namespace rubble::recognizer
