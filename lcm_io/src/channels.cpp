#include "lcm_io/channels.h"

#include <algorithm>
#include <array>

#include "common/error.h"

namespace rubble::lcm_io {

namespace {

using enum ChannelClass;

constexpr std::array kTable = {
    ChannelInfo{channel::kCamera, "bot_core.image_t", kSource, "camera", 4, true},
    ChannelInfo{channel::kCameraInfo, "rubble.camera_info_t", kSource, "camera", 4, true},
    ChannelInfo{channel::kScan, "bot_core.planar_lidar_t", kSource, "lidar", 40, true},
    ChannelInfo{channel::kStabilizer, "rubble.stabilizer_t", kSource, "stabilizer", 200, true},
    ChannelInfo{channel::kOdometry, "rubble.odometry_t", kSource, "", 200, true},
    ChannelInfo{channel::kGroundTruth, "rubble.ground_truth_t", kSource, "arena_sim", 200, true},
    ChannelInfo{channel::kMonoFeatures, "rubble.mono_features_t", kDerived, "slam_mono", 4, false},
    ChannelInfo{channel::kMonoPose, "rubble.mono_pose_t", kDerived, "slam_mono", 100, true},
    ChannelInfo{channel::kMonoMap, "rubble.mono_map_t", kDerived, "slam_mono", 40, true},
    ChannelInfo{channel::kLidarPose, "rubble.lidar_pose_t", kDerived, "slam_lidar", 100, true},
    ChannelInfo{channel::kGridMap, "rubble.grid_map_t", kDerived, "slam_lidar", 40, true},
    ChannelInfo{channel::kRobotPose, "rubble.robot_pose_t", kDerived, "fusion", 200, true},
    ChannelInfo{channel::kFusionState, "rubble.fusion_state_t", kDerived, "fusion", 40, true},
    ChannelInfo{channel::kTrajectory, "rubble.trajectory_t", kDerived, "fusion", 40, true},
    ChannelInfo{channel::kDetections, "rubble.detections_t", kDerived, "recognizer", 40, true},
    ChannelInfo{channel::kObjectNotice, "rubble.object_notice_t", kDerived, "recognizer", 10, true},
    ChannelInfo{channel::kObjects, "rubble.objects_t", kDerived, "fusion", 10, true},
    ChannelInfo{channel::kHealth, "rubble.health_t", kDerived, "", 100, true},
    ChannelInfo{channel::kRevisitRequest, "rubble.revisit_request_t", kCommand, "slam_mono", 40, true},
    ChannelInfo{channel::kLidarControl, "rubble.lidar_control_t", kCommand, "fusion", 40, true},
    ChannelInfo{channel::kStabilizerCommand, "rubble.stabilizer_command_t", kCommand, "fusion", 40, true},
    ChannelInfo{channel::kCommand, "rubble.command_t", kCommand, "", 40, true},
};

}  // namespace

std::span<const ChannelInfo> channelTable() { return kTable; }

const ChannelInfo* findChannel(std::string_view name) {
  const auto* row =
      std::find_if(kTable.begin(), kTable.end(), [&](const ChannelInfo& c) { return c.name == name; });
  return row == kTable.end() ? nullptr : row;
}

bool isSource(std::string_view channel) {
  const ChannelInfo* info = findChannel(channel);
  return info != nullptr && info->channel_class == kSource;
}

std::string_view toString(ChannelClass channel_class) {
  switch (channel_class) {
    case kSource:
      return "source";
    case kDerived:
      return "derived";
    case kCommand:
      return "command";
  }
  RUBBLE_CHECK(false);
}

}  // namespace rubble::lcm_io
