#pragma once

#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "alignment.h"
#include "common/history.h"
#include "common/keyframe_poses.h"
#include "fusion_config.h"
#include "fusion_memory.h"
#include "mount_check.h"

namespace rubble::fusion {

/// The last metres of way in H, as pictures that hang on keyframes, so that a correction of the monocular map
/// moves them along.
class AlignmentWindow {
 public:
  AlignmentWindow(const FusionConfig& config, const common::Pose3& T_body_camera);

  /// A picture, and the rest of its sample (without T_mono_camera, which the keyframes tell). Pictures that
  /// are too near the last one are left out.
  void add(const common::AnchoredPose& picture, const AlignmentSample& pose);

  void clear() { samples_.clear(); }

  /// Estimates how the map lies in world. Empty where the motion does not show it.
  std::optional<MapAlignment> solve(std::int32_t map_id, const common::KeyframePoses& keyframes,
                                    const MapAlignment& last);

  /// What the motion says against the calibration; empty when nothing.
  std::string complaint() const { return mount_.complaint(); }

 private:
  struct Sample {
    common::AnchoredPose picture;
    AlignmentSample pose;
  };

  void trim();
  void checkMount(std::span<const AlignmentSample> samples, const Similarity& S_world_mono);

  const FusionConfig config_;
  const common::Pose3 T_camera_body_;
  std::deque<Sample> samples_;
  MountCheck mount_;
  double way_since_check_ = 0.0;  // m
};

}  // namespace rubble::fusion
