#pragma once

#include <bot_core/planar_lidar_t.hpp>
#include <cstdint>
#include <deque>
#include <rubble/camera_info_t.hpp>
#include <rubble/command_t.hpp>
#include <rubble/detections_t.hpp>
#include <rubble/mono_features_t.hpp>
#include <string>

#include "common/keyframe_poses.h"
#include "common/robot_config.h"
#include "lcm_io/bus.h"
#include "marks/lidar_range.h"
#include "marks/object_marks.h"
#include "pose_fusion.h"

namespace rubble::fusion {

/// DETECTIONS, MONO_FEATURES to OBJECTS: gives what the recogniser sees its place in world, keeps the marks,
/// obeys the operator.
class MarkKeeper {
 public:
  /// `fusion`, `keyframes`: looked at, not changed; they outlive it.
  MarkKeeper(lcm_io::Bus& bus, const MarksConfig& config, const common::RobotConfig& robot,
             const PoseFusion& fusion, const common::KeyframePoses& keyframes);

  /// A state that was published.
  void addState(const RobotState& state, std::int32_t level);
  /// Pictures of the monocular map at `revision`, whose keyframes are known by now.
  void addPictures(std::span<const common::AnchoredPose> pictures, std::int64_t revision);
  /// Repeats OBJECTS when it is time.
  void publish(common::Utime now);

  const ObjectMarks& marks() const { return marks_; }
  void restore(const FusionMemory& memory) { marks_.restore(memory.marks, memory.next_mark_id); }
  std::int64_t sightings() const { return sightings_; }
  /// Pictures with sightings that came too late for their pose, or while the attitude was unknown.
  std::int64_t misses() const { return misses_; }

  /// The scan nearest to that time; null without one within 50 ms.
  const RangeScan* scanAt(common::Utime utime) const;

 private:
  void onScan(const bot_core::planar_lidar_t& scan);
  void onFeatures(const rubble::mono_features_t& message);
  void onDetections(const rubble::detections_t& message);
  void onCommand(const rubble::command_t& command);
  /// Sightings whose picture's pose is known.
  void useWaiting();
  std::vector<Sighting> sightingsOf(const rubble::detections_t& message, const PicturePlace& place) const;
  /// The features in a solid thing's box; none where they were lost on the bus.
  std::vector<BoxFeature> featuresIn(const rubble::detection_t& detection, common::Utime utime) const;
  std::optional<Similarity> locate(std::int32_t keyframe_id) const;

  lcm_io::Bus& bus_;
  const common::Pose3 T_body_camera_;
  const PoseFusion& fusion_;
  const common::KeyframePoses& keyframes_;
  common::RobotConfig::Intrinsics camera_;
  ObjectMarks marks_;
  std::deque<PicturePlace> places_;                             // Of the last seconds.
  std::deque<RangeScan> scans_;                                 // Of the last seconds.
  std::deque<rubble::mono_features_t> features_;                // Of the last seconds.
  std::deque<rubble::detections_t> waiting_;                    // For their picture's pose.
  std::deque<std::pair<common::Utime, std::int32_t>> anchors_;  // Pictures with their keyframes.
  std::int64_t revision_ = 0;
  std::int64_t sightings_ = 0;
  std::int64_t misses_ = 0;
  common::Utime last_published_ = 0;
  bool changed_ = false;
};

}  // namespace rubble::fusion
