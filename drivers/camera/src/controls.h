#pragma once

#include <string>
#include <vector>

#include "camera_config.h"
#include "system_calls.h"

namespace rubble::camera {

/// What became of the exposure, gain and rate that were asked for.
struct ControlOutcome {
  /// s; 0 when the camera chooses and does not tell.
  double exposure = 0.0;
  /// Sentences for HEALTH, one for each wish that was not granted.
  std::vector<std::string> complaints;
};

/// Sets what is configured on an open device whose format is set. A control that is missing is no error.
ControlOutcome applyControls(SystemCalls& calls, int fd, const CameraSetup& setup);

}  // namespace rubble::camera
