#include "slam_mono/live_mono_slam.h"

#include <gmock/gmock.h>

#include "map/map_file.h"
#include "support/error_text.h"
#include "synthetic_route.h"
#include "synthetic_scenes.h"

namespace rubble::slam_mono {
namespace {

class LiveMonoSlamTest : public testing::Test {
 protected:
  LiveMonoSlamTest() {
    Route route(path_.at(0.0), 15.0, 1);
    route.drive(path_, 0.0, 3.0, 0.5);
    poses_ = route.poses();
  }
  /// Returns how many were tracked.
  int feed(SlamEngine& slam, common::Utime offset = 0) {
    Dice dice(1);
    int tracked = 0;
    for (const StampedPose& pose : poses_) {
      const auto result =
          slam.addFrame(pose.utime + offset, scene_.world.view(camera_, pose.T_world_camera, {}, dice));
      tracked += result.state == TrackingState::kTracking ? 1 : 0;
    }
    return tracked;
  }

  const Camera camera_ = arenaCamera();
  const SyntheticScene scene_ = makeRoom(1);
  const FloorPath path_{scene_.line, scene_.closed, 0.8};
  std::vector<StampedPose> poses_;
};

TEST_F(LiveMonoSlamTest, TracksWhileItsThreadsMap) {
  LiveMonoSlam slam(camera_, {});
  EXPECT_GT(feed(slam), static_cast<int>(poses_.size() / 2));
  slam.finish();
  EXPECT_GT(slam.map()->keyframeCount(), 2U);
  EXPECT_FALSE(slam.takeLocated().empty());
}

TEST_F(LiveMonoSlamTest, StopsInTheMiddleOfItsWork) {
  LiveMonoSlam slam(camera_, {});
  feed(slam);
}

TEST_F(LiveMonoSlamTest, GoesOnInAMapPutIntoIt) {
  LiveMonoSlam first(camera_, {});
  feed(first);
  first.finish();
  const auto bytes = serialiseMap(*first.map());
  MonoSlamConfig config;
  config.localisation_only = true;
  LiveMonoSlam second(camera_, config);
  second.replaceMap(parseMap(bytes, camera_, config.orb.levels));
  EXPECT_GT(feed(second), static_cast<int>(0.95 * static_cast<double>(poses_.size())));
  EXPECT_EQ(second.map()->keyframeCount(), first.map()->keyframeCount());
}

}  // namespace
}  // namespace rubble::slam_mono
