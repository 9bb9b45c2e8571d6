#pragma once

#include <memory>
#include <optional>
#include <span>

#include "map/matching.h"
#include "slam_mono/frame_result.h"
#include "slam_mono/mono_slam_config.h"
#include "tracking/initializer.h"
#include "tracking/relocaliser.h"
#include "tracking/requests.h"

namespace rubble::slam_mono {

/// Follows the camera frame by frame against snapshots of the map, and says which frames the map needs. Finds
/// itself again when lost, and meanwhile prepares a new map. Reads maps, never changes one.
class Tracker {
 public:
  Tracker(const Camera& camera, const OctaveScales& scales, const MonoSlamConfig& config);

  struct Output {
    FrameResult result;
    MapRequest request;
  };
  /// `mapper_free`: a keyframe would be taken up soon.
  Output track(const std::shared_ptr<const Frame>& frame, const std::shared_ptr<const Map>& map,
               bool mapper_free);

  /// The map that was asked for stands, `second` is the keyframe of its second view: tracking goes on there.
  /// Returns poses of the frames that waited for it, oldest first.
  std::vector<FrameResult> begin(const Map& map, KeyframeId second);
  /// The camera may be anywhere in this map, most likely near the keyframe: a restored map.
  void expectNear(KeyframeId keyframe);

 private:
  struct Last {
    std::shared_ptr<const Frame> frame;
    PointMatches points;
    RelativePose pose;
    common::Pose3 T_camera_mono = common::Pose3::Identity();  // As it was reported.
  };
  /// A pose of the present frame with what supports it.
  struct Match {
    common::Pose3 T_camera_mono;
    PointMatches points;
    Eigen::Matrix<double, 6, 6> covariance;
    int inliers = 0;
  };

  static FrameResult locatedAt(const Map& map, common::Utime utime, const Keyframe& reference,
                               const common::Pose3& T_camera_mono,
                               const std::optional<Eigen::Matrix<double, 6, 6>>& covariance);
  std::optional<common::Pose3> lastPose(const Map& map) const;
  std::optional<Match> trackMotion(const std::shared_ptr<const Frame>& frame, const Map& map);
  std::optional<Match> matchFrom(const Frame& frame, const Map& map, const common::Pose3& T_camera_mono,
                                 double radius);
  /// Optimises over the matches and drops outliers.
  Match optimise(const Frame& frame, const Map& map, const common::Pose3& T_camera_mono,
                 PointMatches points) const;
  /// Searches the local map; empty when too little is found.
  std::optional<Match> refine(const Frame& frame, const Map& map, const Match& start, int min_inliers,
                              double radius_factor);
  std::optional<Match> relocalise(const Frame& frame, const std::shared_ptr<const Map>& map);
  std::optional<Match> seekOlderMap(const Frame& frame, const std::shared_ptr<const Map>& map);
  void updateLocal(const Map& map, const PointMatches& points);
  void accept(const std::shared_ptr<const Frame>& frame, const Map& map, Match match);
  bool needsKeyframe(const Frame& frame, const Map& map, bool mapper_free) const;
  MapRequest requestKeyframe();

  const Camera& camera_;
  const OctaveScales& scales_;
  const MonoSlamConfig config_;
  ProjectionMatcher matcher_;
  Initializer initializer_;
  Relocaliser relocaliser_;

  TrackingState state_ = TrackingState::kInitializing;
  std::vector<std::shared_ptr<const Frame>> between_;  // Waiting for the map that was asked for.
  LocalPoints local_;                                  // Of the map at local_epoch_.
  std::uint64_t local_epoch_ = 0;
  KeyframeId local_reference_ = kNoKeyframe;
  int local_age_ = 0;
  std::optional<Last> last_;
  std::optional<common::Pose3> velocity_;  // T_now_last over velocity_time_
  common::Utime velocity_time_ = 0;
  int inliers_ = 0;
  common::Utime last_keyframe_ = 0;
  common::Utime lost_since_ = 0;
  common::Utime tracked_since_ = 0;
  PointStatistics statistics_;
};

}  // namespace rubble::slam_mono
