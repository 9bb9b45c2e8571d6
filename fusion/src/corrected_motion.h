#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <span>

#include "common/keyframe_poses.h"
#include "common/time.h"

namespace rubble::fusion {

/// When the monocular map is corrected, two pictures' poses in it cannot be compared: how the camera has
/// moved meanwhile shows only when MONO_MAP has told where their keyframes are now.
class CorrectedMotion {
 public:
  /// The map was corrected between the picture `before`, from `T_world_before`, and the picture `after`.
  void begin(std::int32_t map_id, common::Utime before, const common::Pose3& T_world_before,
             common::Utime after);
  /// `corrected`: the keyframes are as the correction has left them.
  void addPictures(std::span<const common::AnchoredPose> pictures, const common::KeyframePoses& keyframes,
                   bool corrected);

  struct Motion {
    common::Utime before = 0;
    common::Pose3 T_world_before = common::Pose3::Identity();
    common::Utime after = 0;
    common::Pose3 T_before_after = common::Pose3::Identity();  ///< in units of the map as it is now
  };
  /// Once, when it is known.
  std::optional<Motion> take();

 private:
  std::deque<common::AnchoredPose> pictures_;  // Of the last seconds.
  std::optional<Motion> pending_;
  bool known_ = false;
  std::int32_t map_id_ = 0;
};

}  // namespace rubble::fusion
