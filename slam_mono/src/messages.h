#pragma once

#include <rubble/mono_features_t.hpp>
#include <rubble/mono_keyframe_t.hpp>
#include <rubble/mono_pose_t.hpp>
#include <rubble/mono_removed_keyframe_t.hpp>

#include "common/time.h"
#include "map/map.h"
#include "orb/features.h"
#include "slam_mono/frame_result.h"

namespace rubble::slam_mono {

rubble::mono_features_t featuresMessage(common::Utime utime, const orb::Features& features);
rubble::mono_pose_t poseMessage(const FrameResult& result);
rubble::mono_keyframe_t keyframeMessage(const Keyframe& keyframe);
/// `map`: as it was when it still had the keyframe.
rubble::mono_removed_keyframe_t removedMessage(const Keyframe& keyframe, const Map& map);

}  // namespace rubble::slam_mono
