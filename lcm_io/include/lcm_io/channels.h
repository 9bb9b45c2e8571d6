#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace rubble::lcm_io {

/// What a channel's content stems from. Replay and `rubble play` feed only sources.
enum class ChannelClass { kSource, kDerived, kCommand };

/// One row of the channel table; docs/channels.md shows the same rows, held to it by a test.
struct ChannelInfo {
  std::string_view name;
  std::string_view type;
  ChannelClass channel_class;
  /// The one process that publishes it; empty where several may.
  std::string_view publisher;
  /// What a bounded queue of a subscriber holds before it drops the oldest.
  std::size_t queue_capacity;
  /// Logged by the console by default.
  bool logged;
};

namespace channel {
inline constexpr char kCamera[] = "CAMERA";
inline constexpr char kCameraInfo[] = "CAMERA_INFO";
inline constexpr char kScan[] = "SCAN";
inline constexpr char kStabilizer[] = "STABILIZER";
inline constexpr char kOdometry[] = "ODOMETRY";
inline constexpr char kGroundTruth[] = "GROUND_TRUTH";
inline constexpr char kMonoFeatures[] = "MONO_FEATURES";
inline constexpr char kMonoPose[] = "MONO_POSE";
inline constexpr char kMonoMap[] = "MONO_MAP";
inline constexpr char kLidarPose[] = "LIDAR_POSE";
inline constexpr char kGridMap[] = "GRID_MAP";
inline constexpr char kRobotPose[] = "ROBOT_POSE";
inline constexpr char kFusionState[] = "FUSION_STATE";
inline constexpr char kTrajectory[] = "TRAJECTORY";
inline constexpr char kDetections[] = "DETECTIONS";
inline constexpr char kObjectNotice[] = "OBJECT_NOTICE";
inline constexpr char kObjects[] = "OBJECTS";
inline constexpr char kHealth[] = "HEALTH";
inline constexpr char kRevisitRequest[] = "REVISIT_REQUEST";
inline constexpr char kLidarControl[] = "LIDAR_CONTROL";
inline constexpr char kStabilizerCommand[] = "STABILIZER_COMMAND";
inline constexpr char kCommand[] = "COMMAND";
}  // namespace channel

/// All channels whose messages exist today.
std::span<const ChannelInfo> channelTable();

/// Null for a channel that is not in the table.
const ChannelInfo* findChannel(std::string_view name);

/// Whether the channel is in the table as a source.
bool isSource(std::string_view channel);

std::string_view toString(ChannelClass channel_class);

}  // namespace rubble::lcm_io
