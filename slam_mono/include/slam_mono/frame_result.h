#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "common/geometry.h"
#include "common/time.h"

namespace rubble::slam_mono {

enum class TrackingState { kInitializing, kTracking, kLost };

/// What one picture brought. Lengths in the monocular map's scale.
struct FrameResult {
  common::Utime utime = 0;
  TrackingState state = TrackingState::kInitializing;
  int map_id = 0;  ///< 0 before the first map
  std::int64_t map_revision = 0;
  common::Pose3 T_mono_camera = common::Pose3::Identity();  ///< the last known one unless tracking
  /// Of (x, y, z; rotation vector) in mono; infinite unless tracking.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  int inliers = 0;  ///< map points that support the pose
  /// The pose relative to a keyframe, which later corrections move along: -1 unless tracking.
  std::int32_t keyframe_id = -1;
  common::Pose3 T_keyframe_camera = common::Pose3::Identity();
  double keyframe_scale = 1.0;  ///< the keyframe's scale at the time
};

}  // namespace rubble::slam_mono
