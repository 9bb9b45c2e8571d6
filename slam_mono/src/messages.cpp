#include "messages.h"

#include <cmath>
#include <cstring>

#include "common/error.h"
#include "lcm_io/conversions.h"

namespace rubble::slam_mono {

using rubble::mono_pose_t;

rubble::mono_features_t featuresMessage(common::Utime utime, const orb::Features& features) {
  rubble::mono_features_t message;
  message.utime = utime;
  message.width = features.width;
  message.height = features.height;
  message.n = static_cast<std::int32_t>(features.size());
  message.x = features.x;
  message.y = features.y;
  message.angle = features.angle;
  message.noctaves = message.n;
  message.octave = features.octave;
  message.ndescriptors = message.n * static_cast<std::int32_t>(sizeof(orb::Descriptor));
  message.descriptors.resize(features.size() * sizeof(orb::Descriptor));
  if (!features.descriptors.empty()) {
    std::memcpy(message.descriptors.data(), features.descriptors.data(), message.descriptors.size());
  }
  return message;
}

mono_pose_t poseMessage(const FrameResult& result) {
  mono_pose_t message;
  message.utime = result.utime;
  switch (result.state) {
    case TrackingState::kInitializing:
      message.state = mono_pose_t::STATE_INITIALIZING;
      break;
    case TrackingState::kTracking:
      message.state = mono_pose_t::STATE_TRACKING;
      break;
    case TrackingState::kLost:
      message.state = mono_pose_t::STATE_LOST;
      break;
  }
  message.map_id = result.map_id;
  message.map_revision = result.map_revision;
  lcm_io::poseToMessage(result.T_mono_camera, message.p_mono_camera, message.q_mono_camera);
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column < 6; ++column) {
      message.covariance[6 * row + column] = result.covariance(row, column);
    }
  }
  message.inliers = result.inliers;
  return message;
}

rubble::mono_keyframe_t keyframeMessage(const Keyframe& keyframe) {
  rubble::mono_keyframe_t message;
  message.utime = keyframe.frame->utime;
  message.id = keyframe.id;
  message.map_id = keyframe.map_id;
  message.scale = keyframe.scale;
  lcm_io::poseToMessage(keyframe.T_camera_mono.inverse(), message.p_mono_camera, message.q_mono_camera);
  message.parent = keyframe.parent;
  return message;
}

rubble::mono_removed_keyframe_t removedMessage(const Keyframe& keyframe, const Map& map) {
  const Keyframe* parent = map.keyframe(keyframe.parent);
  const common::Pose3 T_mono_camera = keyframe.T_camera_mono.inverse();
  rubble::mono_removed_keyframe_t message;
  message.id = keyframe.id;
  message.map_id = keyframe.map_id;
  message.parent = parent != nullptr ? parent->id : kNoKeyframe;
  message.parent_scale = parent != nullptr ? parent->scale : 1.0;
  lcm_io::poseToMessage(parent != nullptr ? parent->T_camera_mono * T_mono_camera : T_mono_camera,
                        message.p_parent_camera, message.q_parent_camera);
  message.scale = keyframe.scale;
  return message;
}

}  // namespace rubble::slam_mono
