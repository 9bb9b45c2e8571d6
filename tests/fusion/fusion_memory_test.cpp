#include "fusion_memory.h"

#include <gtest/gtest.h>

#include "common/error.h"
#include "drive.h"
#include "pose_fusion.h"

namespace rubble::fusion {
namespace {

FusionMemory example() {
  FusionMemory memory;
  memory.last.utime = 123;
  memory.last.T_world_camera = test::windingPath(2.0);
  memory.last.tracking = true;
  memory.last.map_id = 2;
  memory.last.map_revision = 5;
  memory.last.T_mono_camera = test::T_mono_camera(memory.last.T_world_camera, test::S_world_mono());
  memory.state = ControlState::kM;
  memory.revision = 9;
  memory.levels.push_back({.floor = 1.2, .origin = {3.0, 4.0}, .covariance = Eigen::Matrix4d::Identity()});
  memory.level = 1;
  memory.attitude_known = false;
  memory.maps[1] = {test::S_world_mono(), 0.01, true, 4.0};
  memory.maps[2] = {};
  Mark mark;
  mark.id = 4;
  mark.label = {"qr", "qr", "room 7"};
  mark.state = MarkState::kDiscarded;
  mark.by_operator = true;
  mark.is_flat = true;
  mark.kept_views = {{}};
  mark.seen_beside = {2, 3};
  memory.marks = {mark};
  memory.next_mark_id = 5;
  return memory;
}

TEST(FusionMemory, AStateWithoutAPictureIsWhole) {
  PoseFusion fusion(FusionConfig{}, common::RobotConfig{});
  fusion.addMono(
      {.utime = 1'000'000, .tracking = true, .map_id = 1, .T_mono_camera = test::windingPath(1.0)});
  fusion.advance(1'100'000);
  EXPECT_EQ(fusion.memory().last.T_mono_camera.matrix(), common::Pose3::Identity().matrix());
  EXPECT_NO_THROW(parseFusionMemory(serialise(fusion.memory())));
}

TEST(FusionMemory, ComesBackAsItWas) {
  const auto bytes = serialise(example());
  EXPECT_EQ(serialise(parseFusionMemory(bytes)), bytes);
  const FusionMemory memory = parseFusionMemory(bytes);
  EXPECT_EQ(memory.state, ControlState::kM);
  EXPECT_EQ(memory.revision, 9);
  ASSERT_EQ(memory.levels.size(), 2);
  EXPECT_EQ(memory.level, 1);
  EXPECT_DOUBLE_EQ(memory.levels[1].floor, 1.2);
  EXPECT_EQ(memory.levels[1].covariance, Eigen::Matrix4d::Identity());
  EXPECT_FALSE(memory.attitude_known);
  EXPECT_DOUBLE_EQ(memory.maps.at(1).S_world_mono.scale, test::S_world_mono().scale);
  EXPECT_DOUBLE_EQ(memory.maps.at(1).way, 4.0);
  EXPECT_FALSE(memory.maps.at(2).scale_known);
  ASSERT_EQ(memory.marks.size(), 1);
  EXPECT_EQ(memory.marks.front().label, (ObjectLabel{"qr", "qr", "room 7"}));
  EXPECT_EQ(memory.marks.front().state, MarkState::kDiscarded);
  EXPECT_TRUE(memory.marks.front().is_flat);
  EXPECT_EQ(memory.next_mark_id, 5);
}

TEST(FusionMemory, DamageIsRefused) {
  const auto bytes = serialise(example());
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_THROW(parseFusionMemory(std::span(bytes).first(size)), common::Error) << size;
  }
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    auto damaged = bytes;
    damaged[i] ^= 0x10;
    EXPECT_THROW(parseFusionMemory(damaged), common::Error) << i;
  }
}

TEST(FusionMemory, ALevelThatDoesNotExistIsRefused) {
  for (const std::int32_t level : {-1, 2}) {
    FusionMemory memory = example();
    memory.level = level;
    EXPECT_THROW(parseFusionMemory(serialise(memory)), common::Error) << level;
  }
}

}  // namespace
}  // namespace rubble::fusion
