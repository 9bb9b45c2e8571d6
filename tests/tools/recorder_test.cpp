#include "recorder.h"

#include <gtest/gtest.h>

#include <rubble/mono_map_t.hpp>
#include <rubble/mono_pose_t.hpp>
#include <string>

#include "common/files.h"
#include "lcm_io/channels.h"
#include "lcm_io/conversions.h"
#include "lcm_io/replay_hub.h"
#include "support/temp_dir.h"

namespace rubble::tools {
namespace {

using common::Pose3;
using common::Utime;

Pose3 pose(double x, double y, double yaw) { return common::pose3FromPose2({x, y, yaw}, 0.1 * x); }

/// p scaled, rotation kept.
Pose3 scaled(Pose3 T, double scale) {
  T.translation() *= scale;
  return T;
}

rubble::mono_keyframe_t keyframe(std::int32_t id, std::int32_t map_id, const Pose3& T_mono_camera,
                                 double scale) {
  rubble::mono_keyframe_t k{};
  k.id = id;
  k.map_id = map_id;
  k.scale = scale;
  k.parent = id - 1;
  lcm_io::poseToMessage(T_mono_camera, k.p_mono_camera, k.q_mono_camera);
  return k;
}

rubble::mono_frame_t frame(Utime utime, std::int32_t keyframe, double scale, const Pose3& T_keyframe_camera) {
  rubble::mono_frame_t f{};
  f.utime = utime;
  f.keyframe_id = keyframe;
  f.keyframe_scale = scale;
  lcm_io::poseToMessage(T_keyframe_camera, f.p_keyframe_camera, f.q_keyframe_camera);
  return f;
}

rubble::mono_removed_keyframe_t removed(std::int32_t id, double scale, std::int32_t parent,
                                        double parent_scale, const Pose3& T_parent_camera) {
  rubble::mono_removed_keyframe_t k{};
  k.id = id;
  k.map_id = 1;
  k.parent = parent;
  k.parent_scale = parent_scale;
  k.scale = scale;
  lcm_io::poseToMessage(T_parent_camera, k.p_parent_camera, k.q_parent_camera);
  return k;
}

class RecorderTest : public testing::Test {
 protected:
  RecorderTest() : recorder_(hub_.endpoint()) {}

  void feed(rubble::mono_map_t map) {
    map.nkeyframes = static_cast<std::int32_t>(map.keyframes.size());
    map.nremoved = static_cast<std::int32_t>(map.removed.size());
    map.nframes = static_cast<std::int32_t>(map.frames.size());
    hub_.feed({lcm_io::channel::kMonoMap, ++now_, lcm_io::encode(map)});
  }
  void feedPose(Utime utime, std::int8_t state, std::int32_t map_id, const Pose3& T_mono_camera) {
    rubble::mono_pose_t message{};
    message.utime = utime;
    message.state = state;
    message.map_id = map_id;
    lcm_io::poseToMessage(T_mono_camera, message.p_mono_camera, message.q_mono_camera);
    hub_.feed({lcm_io::channel::kMonoPose, ++now_, lcm_io::encode(message)});
  }
  common::Trajectory written(const std::string& name) {
    recorder_.write(dir_.path());
    return common::readTum(dir_.path() / name);
  }

  lcm_io::ReplayHub hub_;
  Recorder recorder_;
  test::TempDir dir_;
  Utime now_ = 0;
};

TEST_F(RecorderTest, FramesMoveAndGrowWithTheirKeyframe) {
  const Pose3 T_keyframe_camera = pose(0.2, 0.1, 0.3);
  rubble::mono_map_t map{};
  map.keyframes = {keyframe(0, 1, pose(0, 0, 0), 1.0), keyframe(1, 1, pose(1, 0, 0), 1.0)};
  map.frames = {frame(1000, 0, 1.0, T_keyframe_camera), frame(2000, 1, 1.0, T_keyframe_camera)};
  feed(map);
  map.frames.clear();
  map.keyframes = {keyframe(1, 1, pose(5, 3, 1), 2.5)};
  feed(map);
  const common::Trajectory final = written("trajectory_mono_final.tum");
  ASSERT_EQ(final.size(), 2U);
  EXPECT_TRUE(final[0].T_a_b.isApprox(T_keyframe_camera, 1e-6));
  EXPECT_TRUE(final[1].T_a_b.isApprox(pose(5, 3, 1) * scaled(T_keyframe_camera, 2.5), 1e-6));
}

TEST_F(RecorderTest, FramesOfRemovedKeyframesMoveOnWithTheParents) {
  // A chain 0 <- 1 <- 2 whose middle and end are removed, the parents having grown in between.
  const Pose3 T_2_camera = pose(0.2, 0.1, 0.3);
  const Pose3 T_1_2 = pose(0.5, 0.2, -0.4);
  const Pose3 T_0_1 = pose(1.0, -0.3, 0.2);
  rubble::mono_map_t map{};
  map.frames = {frame(1000, 2, 1.0, T_2_camera)};
  map.removed = {removed(2, 2.0, 1, 1.5, T_1_2)};
  feed(map);
  map.frames.clear();
  map.removed = {removed(1, 3.0, 0, 1.0, T_0_1)};
  map.keyframes = {keyframe(0, 1, pose(7, 1, 2), 4.0)};
  feed(map);
  const common::Trajectory final = written("trajectory_mono_final.tum");
  ASSERT_EQ(final.size(), 1U);
  const double growth_0 = 4.0 / 1.0;
  const double growth_1 = growth_0 * 3.0 / 1.5;
  const double growth_2 = growth_1 * 2.0 / 1.0;
  const Pose3 expected =
      pose(7, 1, 2) * scaled(T_0_1, growth_0) * scaled(T_1_2, growth_1) * scaled(T_2_camera, growth_2);
  EXPECT_TRUE(final[0].T_a_b.isApprox(expected, 1e-6));
}

TEST_F(RecorderTest, OnlyTheLargestMapsFramesAreInTheFinalTrajectory) {
  rubble::mono_map_t map{};
  map.keyframes = {keyframe(0, 1, pose(0, 0, 0), 1.0), keyframe(1, 2, pose(1, 0, 0), 1.0),
                   keyframe(2, 3, pose(2, 0, 0), 1.0)};
  map.frames = {frame(1000, 0, 1.0, pose(0, 0, 0)), frame(2000, 1, 1.0, pose(0, 0, 0)),
                frame(3000, 1, 1.0, pose(0.1, 0, 0)), frame(4000, 2, 1.0, pose(0, 0, 0))};
  feed(map);
  testing::internal::CaptureStderr();
  EXPECT_EQ(written("trajectory_mono_final.tum").size(), 2U);
  EXPECT_NE(testing::internal::GetCapturedStderr().find("2 of other maps"), std::string::npos);
  map.frames.clear();
  map.keyframes = {keyframe(2, 2, pose(1.2, 0, 0), 1.0)};
  feed(map);
  const common::Trajectory merged = written("trajectory_mono_final.tum");
  ASSERT_EQ(merged.size(), 3U) << "map 3 became part of map 2";
  EXPECT_EQ(merged.back().utime, 4000);
}

TEST_F(RecorderTest, AFrameWithoutKeyframeIsLeftOutAndSaid) {
  rubble::mono_map_t map{};
  map.keyframes = {keyframe(0, 1, pose(0, 0, 0), 1.0)};
  map.frames = {frame(1000, 0, 1.0, pose(0, 0, 0)), frame(2000, 7, 1.0, pose(0, 0, 0)),
                frame(3000, 5, 1.0, pose(0, 0, 0))};
  map.removed = {removed(5, 1.0, 6, 1.0, pose(0, 0, 0)), removed(6, 1.0, 5, 1.0, pose(0, 0, 0))};
  feed(map);
  testing::internal::CaptureStderr();
  EXPECT_EQ(written("trajectory_mono_final.tum").size(), 1U);
  EXPECT_NE(testing::internal::GetCapturedStderr().find("2 tracked pictures"), std::string::npos);
}

TEST_F(RecorderTest, PosesOfAllMapsAndStatesAreInPosesCsv) {
  EXPECT_TRUE(recorder_.empty());
  feedPose(1'000'000, rubble::mono_pose_t::STATE_INITIALIZING, 0, pose(0, 0, 0));
  feedPose(1'050'000, rubble::mono_pose_t::STATE_TRACKING, 1, pose(1, 2, 0.5));
  feedPose(1'100'000, rubble::mono_pose_t::STATE_LOST, 1, pose(1, 2, 0.5));
  EXPECT_FALSE(recorder_.empty());
  const common::Trajectory published = written("trajectory_mono.tum");
  ASSERT_EQ(published.size(), 1U);
  EXPECT_EQ(published[0].utime, 1'050'000);
  const auto bytes = common::readFile(dir_.path() / "poses.csv");
  const std::string csv(bytes.begin(), bytes.end());
  const std::string header = csv.substr(0, csv.find('\n'));
  for (const char* line :
       {"mono,1.000000,",
        "mono,1.050000,1.000000000,2.000000000,0.100000000,0.000000000,-0.000000000,0.500000000,1,,tracking,",
        "mono,1.100000,"}) {
    const std::size_t at = csv.find(line);
    ASSERT_NE(at, std::string::npos) << line << " in\n" << csv;
    const std::string row = csv.substr(at, csv.find('\n', at) - at);
    EXPECT_EQ(std::count(row.begin(), row.end(), ','), std::count(header.begin(), header.end(), ',')) << row;
  }
}

}  // namespace
}  // namespace rubble::tools
