#include <gmock/gmock.h>

#include "synthetic_mission.h"
#include "synthetic_scenes.h"

// One slice each of what `mono_trials` measures over many seeds.

namespace rubble::slam_mono {
namespace {

/// Along the scene's line and `more` metres on.
Mission driven(const SyntheticScene& scene, double more, const MonoSlamConfig& config) {
  const FloorPath path(scene.line, scene.closed, 0.8);
  Route route(path.at(0.0), 15.0, 1);
  route.drive(path, 0.0, path.length() + more, 0.5);
  // The lens is not quite what the calibration says: that makes drift.
  common::RobotConfig::Intrinsics lens;
  lens.distortion = {-0.22, 0.045, 0.0006, -0.0004};
  lens.focal = {371.0, 371.0};
  Mission mission(scene.world, Camera(lens), arenaCamera(), config, 1);
  mission.follow(route.poses());
  return mission;
}

int ties(const Map& map) {
  int count = 0;
  for (const KeyframeId id : map.keyframes()) {
    count += static_cast<int>(map.keyframe(id)->loops.size());
  }
  return count / 2;
}

TEST(LoopTest, ARingIsClosedAndItsDriftTakenOut) {
  const SyntheticScene scene = makeRing(1);
  const Mission closed = driven(scene, 5.0, {});
  MonoSlamConfig config;
  config.loop.enabled = false;
  const Mission open = driven(scene, 5.0, config);
  EXPECT_GE(ties(*closed.map()), 1);
  EXPECT_EQ(ties(*open.map()), 0);
  const double with = rootMeanSquare(keyframePositions(*closed.map(), closed.frames()).errors());
  const double without = rootMeanSquare(keyframePositions(*open.map(), open.frames()).errors());
  EXPECT_LT(with, without / 3.0);
}

TEST(LoopTest, IdenticalDoorsInLookAlikeCorridorsCloseNothing) {
  const Mission mission = driven(makeLookAlike(1), 0.0, {});
  EXPECT_EQ(ties(*mission.map()), 0);
}

}  // namespace
}  // namespace rubble::slam_mono
