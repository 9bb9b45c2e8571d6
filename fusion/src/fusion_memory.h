#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "alignment.h"
#include "common/time.h"
#include "marks/object_marks.h"
#include "plane_state.h"

namespace rubble::fusion {

/// How a monocular map lies in world.
struct MapAlignment {
  Similarity S_world_mono;
  double scale_sigma = 1.0;  ///< relative
  bool scale_known = false;
  double way = 0.0;  ///< m of the LiDAR's way that the scale was learnt on; 0: it is learnt anew
};

/// One picture's time with what vision said and where the camera was.
struct Track {
  common::Utime utime = 0;
  common::Pose3 T_world_camera = common::Pose3::Identity();
  bool tracking = false;
  std::int32_t map_id = 0;
  std::int64_t map_revision = 0;
  common::Pose3 T_mono_camera = common::Pose3::Identity();
};

/// What must survive the process: with it vision goes on in the same world at the same scale.
struct FusionMemory {
  Track last;
  ControlState state = ControlState::kH;
  std::int64_t revision = 0;
  std::vector<Level> levels{1};
  std::int32_t level = 0;  ///< index in `levels`
  bool attitude_known = true;
  std::map<std::int32_t, MapAlignment> maps;
  std::vector<Mark> marks;
  std::int32_t next_mark_id = 1;
};

std::vector<std::uint8_t> serialise(const FusionMemory& memory);
/// Throws common::Error for bytes that are truncated, corrupt or of another version.
FusionMemory parseFusionMemory(std::span<const std::uint8_t> bytes);

}  // namespace rubble::fusion
