#include "slam_mono/mono_slam.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "map/map_file.h"
#include "support/error_text.h"
#include "synthetic_mission.h"
#include "synthetic_scenes.h"

namespace rubble::slam_mono {
namespace {

constexpr double kRate = 15.0;
constexpr double kSpeed = 0.5;

class MonoSlamTest : public testing::Test {
 protected:
  /// Along the room's line.
  std::vector<StampedPose> drive(double metres) const {
    Route route(path_.at(0.0), kRate, 1);
    route.drive(path_, 0.0, metres, kSpeed);
    return route.poses();
  }
  static std::size_t firstTracked(std::span<const MissionFrame> frames) {
    return static_cast<std::size_t>(std::find_if(frames.begin(), frames.end(), tracked) - frames.begin());
  }
  static bool tracked(const MissionFrame& frame) { return frame.result.state == TrackingState::kTracking; }
  static std::ptrdiff_t trackedCount(std::span<const MissionFrame> frames) {
    return std::count_if(frames.begin(), frames.end(), tracked);
  }
  /// Starts within half a metre, tracks on, and knows where it was to 0.5 % of the way.
  static void expectGood(const Mission& mission) {
    const std::span<const MissionFrame> frames = mission.frames();
    const std::size_t first = firstTracked(frames);
    ASSERT_LT(first, frames.size());
    EXPECT_LT(travelled(frames.first(first + 1)), 0.5);
    const auto after = frames.subspan(first);
    EXPECT_GT(trackedCount(after), 0.98 * static_cast<double>(after.size()));
    const auto reported = reportedPositions(frames);
    ASSERT_EQ(reported.size(), 1U);
    EXPECT_LT(rootMeanSquare(reported.begin()->second.errors()), 0.005 * travelled(frames));
    EXPECT_LT(rootMeanSquare(keyframePositions(*mission.map(), frames).errors()), 0.005 * travelled(frames));
  }

  const SyntheticScene scene_ = makeRoom(1);
  const FloorPath path_{scene_.line, scene_.closed, 0.8};
  Mission mission_{scene_.world, arenaCamera(), MonoSlamConfig{}, 1};
};

TEST_F(MonoSlamTest, KnowsWhereItIsInARoom) {
  mission_.follow(drive(path_.length()));
  expectGood(mission_);
}

TEST_F(MonoSlamTest, WorksWithAFisheye) {
  Mission mission(scene_.world, fisheyeCamera(), MonoSlamConfig{}, 1);
  mission.follow(drive(8.0));
  expectGood(mission);
}

TEST_F(MonoSlamTest, WorksAt30HzWithFewAndPoorFeatures) {
  Route route(path_.at(0.0), 30.0, 1);
  route.drive(path_, 0.0, 5.0, kSpeed);
  mission_.follow(route.poses(), {.features = 400, .clutter = 0.3, .pixel_noise = 0.7});
  expectGood(mission_);
}

TEST_F(MonoSlamTest, NeverStartsFromTurningOnTheSpot) {
  Route route(path_.at(0.0), kRate, 1);
  route.turn(2.0 * std::numbers::pi, 10.0);
  route.turn(-std::numbers::pi, 2.0);
  mission_.follow(route.poses());
  EXPECT_EQ(trackedCount(mission_.frames()), 0);
  EXPECT_EQ(mission_.map()->keyframeCount(), 0U);
}

TEST_F(MonoSlamTest, NeverStartsFromStandingStill) {
  Route route(path_.at(0.0), kRate, 1);
  route.stand(15.0);
  mission_.follow(route.poses());
  EXPECT_EQ(trackedCount(mission_.frames()), 0);
}

TEST_F(MonoSlamTest, StartsAfterTurningAndStanding) {
  Route route(path_.at(0.0), kRate, 1);
  route.stand(2.0);
  route.turn(0.5, 1.0);
  route.turn(-0.5, 1.0);
  route.drive(path_, 0.0, 3.0, kSpeed);
  mission_.follow(route.poses());
  expectGood(mission_);
}

TEST_F(MonoSlamTest, NoViewHasMoreThanAFewKeyframesHoweverOftenItIsSeen) {
  const std::vector<Eigen::Vector2d> square{{-4.0, -3.0}, {-2.0, -3.0}, {-2.0, -1.0}, {-4.0, -1.0}};
  const FloorPath small(square, true, 0.8);
  Route route(small.at(0.0), kRate, 1);
  route.drive(small, 0.0, 4.0 * small.length(), kSpeed);
  mission_.follow(route.poses(), {.detected = 0.5});
  const auto map = mission_.map();
  const auto ids = map->keyframes();
  ASSERT_GT(ids.size(), 20U);
  const auto alike = [&](KeyframeId a, KeyframeId b) {
    const Keyframe& k = *map->keyframe(a);
    const Keyframe& other = *map->keyframe(b);
    return (k.p_mono_camera() - other.p_mono_camera()).norm() < 0.18 * map->medianDistance(a) &&
           k.T_camera_mono.linear().row(2).dot(other.T_camera_mono.linear().row(2)) > std::cos(0.3);
  };
  for (const KeyframeId id : ids) {
    if (id < ids.back() - 40) {
      EXPECT_LE(std::count_if(ids.begin(), ids.end(),
                              [&](KeyframeId other) { return other < id && alike(id, other); }),
                3)
          << id;
    }
  }
}

TEST_F(MonoSlamTest, SurvivesASecondInTheDark) {
  const auto poses = drive(6.0);
  Dice dice(1);
  const std::size_t dark = 90;
  const std::size_t light = dark + static_cast<std::size_t>(kRate);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (i >= dark && i < light) {
      const MissionFrame& frame = mission_.add(poses[i], SyntheticWorld::clutter(arenaCamera(), 0, dice));
      EXPECT_EQ(frame.result.state, TrackingState::kLost);
      EXPECT_EQ(frame.result.keyframe_id, kNoKeyframe);
      EXPECT_FALSE(frame.result.covariance.allFinite());
    } else {
      mission_.look(poses[i]);
    }
  }
  const auto& frames = mission_.frames();
  ASSERT_TRUE(tracked(frames[dark - 1]));
  EXPECT_TRUE(tracked(frames[light + 2]));
  EXPECT_EQ(frames.back().result.map_id, frames[dark - 1].result.map_id);
  const auto reported = reportedPositions(frames);
  ASSERT_EQ(reported.size(), 1U);
  EXPECT_LT(rootMeanSquare(reported.begin()->second.errors()), 0.005 * travelled(frames));
}

TEST_F(MonoSlamTest, SurvivesMissingPictures) {
  const auto poses = drive(8.0);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    // A third of a second, time and again.
    if (i < 60 || i % 20 >= 5) {
      mission_.look(poses[i]);
    }
  }
  expectGood(mission_);
}

TEST_F(MonoSlamTest, RefusesTimeThatGoesBack) {
  const auto poses = drive(2.0);
  Mission undisturbed(scene_.world, arenaCamera(), MonoSlamConfig{}, 1);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    mission_.look(poses[i]);
    undisturbed.look(poses[i]);
    for (const common::Utime back : {0, 1, 10'000'000}) {
      EXPECT_THAT(test::errorOf([&] { mission_.slam().addFrame(poses[i].utime - back, orb::Features{}); }),
                  testing::HasSubstr("not newer"));
    }
  }
  EXPECT_EQ(serialiseMap(*mission_.map()), serialiseMap(*undisturbed.map()));
}

TEST_F(MonoSlamTest, TwoRunsAreIdentical) {
  const auto poses = drive(4.0);
  Mission again(scene_.world, arenaCamera(), MonoSlamConfig{}, 1);
  mission_.follow(poses);
  again.follow(poses);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const FrameResult& a = mission_.frames()[i].result;
    const FrameResult& b = again.frames()[i].result;
    ASSERT_EQ(a.state, b.state);
    ASSERT_EQ(a.T_mono_camera.matrix(), b.T_mono_camera.matrix());
    ASSERT_EQ(a.inliers, b.inliers);
    ASSERT_EQ(a.keyframe_id, b.keyframe_id);
  }
  EXPECT_EQ(serialiseMap(*mission_.map()), serialiseMap(*again.map()));
}

}  // namespace
}  // namespace rubble::slam_mono
