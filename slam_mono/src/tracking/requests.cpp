#include "tracking/requests.h"

namespace rubble::slam_mono {

RelativePose RelativePose::of(const Keyframe& keyframe, const common::Pose3& T_camera_mono) {
  return {keyframe.id, T_camera_mono * keyframe.T_camera_mono.inverse(), keyframe.scale};
}

common::Pose3 RelativePose::T_camera_mono(const Keyframe& keyframe) const {
  common::Pose3 T = T_camera_reference;
  T.translation() *= keyframe.scale / reference_scale;
  return T * keyframe.T_camera_mono;
}

}  // namespace rubble::slam_mono
