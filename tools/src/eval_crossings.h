#pragma once

#include <filesystem>
#include <vector>

#include "common/trajectory.h"

namespace rubble::tools {

/// A fused pose with the control state that it was published in.
struct StatedPose {
  common::StampedPose pose;
  char state = 'H';
};

/// The rows of the fusion in a poses.csv. Throws common::Error naming file and line.
std::vector<StatedPose> readFusedStates(const std::filesystem::path& poses_csv);

/// A way on which vision alone carried the pose: from H to M until H is back.
struct Crossing {
  common::Utime utime = 0;   ///< of its begin
  double way_m = 0.0;        ///< of the truth
  double drift = 0.0;        ///< change of the position's error, share of the way
  double scale_error = 0.0;  ///< how much longer the published way is than the true one, share
};

/// Crossings of at least `min_way` (m). Truth is taken at the poses' own stamps.
std::vector<Crossing> findCrossings(const std::vector<StatedPose>& fused, const common::Trajectory& truth,
                                    double min_way);

}  // namespace rubble::tools
