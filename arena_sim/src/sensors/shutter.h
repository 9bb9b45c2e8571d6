#pragma once

#include <array>
#include <vector>

#include "sensors/pose_at.h"

namespace rubble::arena_sim {

/// The camera's way while its shutter is open: for every row the poses that bound `samples` equal parts of
/// the row's exposure.
class Shutter {
 public:
  /// The upper three rows of T_world_camera, one after the other.
  using Pose = std::array<float, 12>;

  /// Row r is exposed for `exposure` s around seconds + readout * (r / rows - 0.5).
  Shutter(double seconds, double exposure, double readout, int rows, int samples,
          const PoseAt& T_world_camera);

  /// samples + 1 poses; any row may be asked for, those below the picture are its last.
  const Pose* row(int row) const;

 private:
  const int parts_;
  const int rows_;  // One when all rows are exposed together.
  std::vector<Pose> poses_;
};

}  // namespace rubble::arena_sim
