#include "slam_lidar/slam_lidar_node.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bot_core/planar_lidar_t.hpp>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <numbers>
#include <optional>
#include <rubble/command_t.hpp>
#include <rubble/grid_map_t.hpp>
#include <rubble/lidar_control_t.hpp>
#include <rubble/lidar_pose_t.hpp>
#include <rubble/robot_pose_t.hpp>
#include <rubble/stabilizer_t.hpp>
#include <utility>
#include <vector>

#include "common/geometry.h"
#include "lcm_io/channels.h"
#include "lcm_io/conversions.h"
#include "lcm_io/replay_hub.h"
#include "support/temp_dir.h"

namespace rubble {
namespace {

using common::Pose2;
using common::Utime;
using lidar_pose_t = rubble::lidar_pose_t;

constexpr Utime kStart = 1'000'000'000;
constexpr Utime kScanPeriod = 100'000;
/// The first scans are known to a cell's side only, and the map with them.
constexpr double kOneCell = 0.05;

/// Range in a 9 m x 6 m room with a pillar, from a pose, along an angle in the room.
double roomRange(const Pose2& T_world_lidar, double angle) {
  // Off the borders of the grid's cells, where rounding would decide which cell is hit.
  const std::array<std::array<double, 4>, 6> walls = {{{-3.02, -2.03, 6.02, -2.03},
                                                       {6.02, -2.03, 6.02, 4.02},
                                                       {6.02, 4.02, -3.02, 4.02},
                                                       {-3.02, 4.02, -3.02, -2.03},
                                                       {2.0, 1.5, 2.8, 1.9},
                                                       {2.8, 1.9, 2.3, 2.6}}};
  const double dx = std::cos(angle);
  const double dy = std::sin(angle);
  double nearest = std::numeric_limits<double>::infinity();
  for (const auto& w : walls) {
    const double ex = w[2] - w[0];
    const double ey = w[3] - w[1];
    const double cross = dx * ey - dy * ex;
    const double ox = w[0] - T_world_lidar.x;
    const double oy = w[1] - T_world_lidar.y;
    const double t = (ox * ey - oy * ex) / cross;
    const double u = (ox * dy - oy * dx) / cross;
    if (t > 0 && u >= 0 && u <= 1) {
      nearest = std::min(nearest, t);
    }
  }
  return nearest;
}

bot_core::planar_lidar_t roomScan(Utime utime, const Pose2& T_world_lidar) {
  bot_core::planar_lidar_t scan;
  scan.utime = utime;
  scan.nranges = 361;
  scan.rad0 = -static_cast<float>(std::numbers::pi) * 0.75F;
  scan.radstep = static_cast<float>(std::numbers::pi) * 1.5F / 360.0F;
  for (int i = 0; i < scan.nranges; ++i) {
    const double angle = static_cast<double>(scan.rad0) + i * static_cast<double>(scan.radstep);
    scan.ranges.push_back(static_cast<float>(roomRange(T_world_lidar, T_world_lidar.yaw + angle)));
  }
  scan.nintensities = 0;
  return scan;
}

/// The node on a hub, its output, and a robot that walks through the room.
class SlamLidarNodeTest : public testing::Test {
 protected:
  SlamLidarNodeTest() { makeNode({}); }

  void makeNode(const std::filesystem::path& state_dir) {
    node_.reset();
    hub_ = std::make_unique<lcm_io::ReplayHub>();
    hub_->advanceTo(now_);
    bus_ = &hub_->endpoint();
    node_ = slam_lidar::makeNode({.bus = *bus_, .config = config_, .state_dir = state_dir});
    lcm_io::Bus& ears = hub_->endpoint();
    ears.subscribe<lidar_pose_t>(lcm_io::channel::kLidarPose,
                                 [this](const auto& pose) { poses_.push_back(pose); });
    ears.subscribe<rubble::grid_map_t>(lcm_io::channel::kGridMap,
                                       [this](const auto& map) { maps_.push_back(map); });
  }

  /// At the files' time: checkpoints have an age.
  void makeNodeNow(const std::filesystem::path& state_dir) {
    now_ = std::chrono::duration_cast<std::chrono::microseconds>(
               std::chrono::system_clock::now().time_since_epoch())
               .count();
    makeNode(state_dir);
  }

  template <typename Message>
  void feed(const char* channel, const Message& message) {
    hub_->advanceTo(now_);
    node_->advance(now_);
    hub_->feed({channel, now_, lcm_io::encode(message)});
    node_->advance(now_);
    hub_->deliverPending();
  }

  void passTime(Utime duration) {
    now_ += duration;
    hub_->advanceTo(now_);
    node_->advance(now_);
    hub_->deliverPending();
  }

  void stand(int scans) { walk(scans, {}); }

  /// The same, with the fused pose.
  void walkFused(int scans) {
    for (int i = 0; i < scans; ++i) {
      rubble::robot_pose_t pose{};
      pose.utime = now_ + kScanPeriod;
      lcm_io::poseToMessage(common::pose3FromPose2(T_world_lidar_ * kStep), pose.p_world_body,
                            pose.q_world_body);
      feed(lcm_io::channel::kRobotPose, pose);
      walk(1);
    }
  }

  /// Tiles of a level as told so far.
  std::map<std::pair<int, int>, std::vector<std::uint8_t>> tilesOf(std::int32_t level) const {
    std::map<std::pair<int, int>, std::vector<std::uint8_t>> tiles;
    for (const rubble::grid_map_t& map : maps_) {
      for (const rubble::grid_tile_t& tile : map.tiles) {
        if (map.level == level) {
          tiles[{tile.tile_x, tile.tile_y}] = tile.data;
        }
      }
    }
    return tiles;
  }

  /// Walks on and feeds one scan per step.
  static constexpr Pose2 kStep{0.04, 0.0, 0.02};
  void walk(int scans, const Pose2& step = kStep) {
    for (int i = 0; i < scans; ++i) {
      now_ += kScanPeriod;
      // The first scan's pose is the origin of world.
      T_world_lidar_ = poses_.empty() ? Pose2{} : T_world_lidar_ * step;
      if (control_) {
        control_->utime = now_;
        feed(lcm_io::channel::kLidarControl, *control_);
      }
      feed(lcm_io::channel::kScan, roomScan(now_, T_world_lidar_));
    }
  }

  void control(std::int8_t state, Utime confirmed_h_utime = 0, std::int32_t level = 0) {
    control_ = rubble::lidar_control_t{};
    control_->state = state;
    control_->revision = ++revision_;
    control_->level = level;
    control_->confirmed_h_utime = confirmed_h_utime;
  }

  double error() const {
    return std::hypot(poses_.back().x - T_world_lidar_.x, poses_.back().y - T_world_lidar_.y);
  }
  std::int64_t mapRevision() const { return poses_.back().map_revision; }

  common::Config config_;
  std::unique_ptr<lcm_io::ReplayHub> hub_;
  lcm_io::Bus* bus_ = nullptr;
  std::unique_ptr<lcm_io::Node> node_;
  std::vector<lidar_pose_t> poses_;
  std::vector<rubble::grid_map_t> maps_;
  Utime now_ = kStart;
  Pose2 T_world_lidar_;
  std::optional<rubble::lidar_control_t> control_;
  std::int64_t revision_ = 0;
};

TEST_F(SlamLidarNodeTest, FollowsTheRobotAndDrawsTheMap) {
  walk(60);
  ASSERT_EQ(poses_.size(), 60U);
  EXPECT_LT(error(), kOneCell);
  EXPECT_EQ(poses_.back().status, lidar_pose_t::STATUS_GOOD);
  EXPECT_EQ(poses_.back().control_revision, -1);
  EXPECT_GT(poses_.back().score, 0.5);
  EXPECT_GT(poses_.back().covariance[0], 0.0);
  EXPECT_FALSE(maps_.empty());
  EXPECT_EQ(node_->status().state, "tracking");
}

TEST_F(SlamLidarNodeTest, AScanWaitsForThePlateThenGoesOnWithout) {
  walk(3);
  rubble::stabilizer_t plate{};
  plate.utime = now_;
  feed(lcm_io::channel::kStabilizer, plate);
  now_ += kScanPeriod;
  const std::size_t before = poses_.size();
  feed(lcm_io::channel::kScan, roomScan(now_, T_world_lidar_));
  EXPECT_EQ(poses_.size(), before) << "the plate's angles have not arrived";
  plate.utime = now_ + 1000;
  now_ += 10'000;
  feed(lcm_io::channel::kStabilizer, plate);
  ASSERT_EQ(poses_.size(), before + 1);
  EXPECT_EQ(poses_.back().flags & lidar_pose_t::FLAG_ATTITUDE_EXTRAPOLATED, 0);

  now_ += kScanPeriod;
  feed(lcm_io::channel::kScan, roomScan(now_, T_world_lidar_));
  EXPECT_EQ(poses_.size(), before + 1);
  passTime(61'000);
  ASSERT_EQ(poses_.size(), before + 2) << "after 60 ms it is extrapolated";
  EXPECT_NE(poses_.back().flags & lidar_pose_t::FLAG_ATTITUDE_EXTRAPOLATED, 0);
  EXPECT_EQ(poses_.back().flags & lidar_pose_t::FLAG_WRITTEN, 0);
}

TEST_F(SlamLidarNodeTest, NoFusedPositionOrHeadingLeaksIntoTheMatch) {
  walk(20);
  const double x = poses_.back().x;
  rubble::robot_pose_t pose{};
  for (int i = 0; i < 20; ++i) {
    now_ += kScanPeriod;
    pose.utime = now_ + 1000;
    common::Pose3 T = common::pose3FromPose2({100.0, -50.0, 2.0});
    lcm_io::poseToMessage(T, pose.p_world_body, pose.q_world_body);
    feed(lcm_io::channel::kRobotPose, pose);
    feed(lcm_io::channel::kScan, roomScan(now_, T_world_lidar_));
  }
  EXPECT_NEAR(poses_.back().x, x, 0.02);
  EXPECT_LT(error(), kOneCell);
}

TEST_F(SlamLidarNodeTest, ScansAreCommittedOnlyWhenConfirmed) {
  control(rubble::lidar_control_t::STATE_H);
  walk(30);
  const std::int64_t first = mapRevision();
  EXPECT_LE(first, 5) << "only the scans that found the map";
  EXPECT_EQ(poses_.back().control_revision, 1);
  control(rubble::lidar_control_t::STATE_H, now_);
  walk(1);
  EXPECT_GT(mapRevision(), first);
}

TEST_F(SlamLidarNodeTest, StateMNeitherMatchesNorWritesAndForgetsWhatWasNotConfirmed) {
  control(rubble::lidar_control_t::STATE_H);
  walk(30);
  const std::int64_t revision = mapRevision();
  control(rubble::lidar_control_t::STATE_M);
  walk(10);
  EXPECT_EQ(poses_.back().status, lidar_pose_t::STATUS_UNMATCHED);
  EXPECT_EQ(node_->status().state, "suspended");
  control(rubble::lidar_control_t::STATE_R, now_);
  walk(10);
  EXPECT_EQ(mapRevision(), revision) << "R matches but writes nothing, and M's end commits nothing";
}

TEST_F(SlamLidarNodeTest, InMThePoseFollowsTheFusedMotionAndIsFoundAgainInR) {
  control(rubble::lidar_control_t::STATE_H);
  stand(5);
  walk(30);
  control(rubble::lidar_control_t::STATE_H, now_);
  walk(1);
  control(rubble::lidar_control_t::STATE_M, now_);
  // The fused pose lies elsewhere in its own world: only how it moves counts.
  const Pose2 T_elsewhere{40.0, -7.0, 0.0};
  for (int i = 0; i < 20; ++i) {
    rubble::robot_pose_t pose{};
    pose.utime = now_ + kScanPeriod;
    const common::Pose3 T = common::pose3FromPose2(T_elsewhere * T_world_lidar_ * Pose2{0.04, 0.0, 0.02});
    lcm_io::poseToMessage(T, pose.p_world_body, pose.q_world_body);
    feed(lcm_io::channel::kRobotPose, pose);
    walk(1);
  }
  EXPECT_EQ(poses_.back().status, lidar_pose_t::STATUS_UNMATCHED);
  EXPECT_LT(error(), 2 * kOneCell);
  control(rubble::lidar_control_t::STATE_R, now_);
  walk(10);
  EXPECT_EQ(poses_.back().status, lidar_pose_t::STATUS_GOOD);
  EXPECT_LT(error(), kOneCell);
}

TEST_F(SlamLidarNodeTest, AnotherLevelHasAGridOfItsOwn) {
  const test::TempDir dir;
  makeNodeNow(dir.path());
  control(rubble::lidar_control_t::STATE_H);
  stand(5);
  walk(30);
  control(rubble::lidar_control_t::STATE_H, now_);
  walkFused(12);
  control(rubble::lidar_control_t::STATE_M, now_);
  walkFused(12);
  const auto ground = tilesOf(0);
  // The robot is moving, and the first second is written as the fused pose says.
  control(rubble::lidar_control_t::STATE_H, now_, 1);
  walkFused(30);
  EXPECT_EQ(poses_.back().level, 1);
  EXPECT_EQ(poses_.back().status, lidar_pose_t::STATUS_GOOD);
  EXPECT_LT(error(), 0.02);
  EXPECT_GT(mapRevision(), 5);
  EXPECT_FALSE(tilesOf(1).empty());
  EXPECT_EQ(tilesOf(0), ground);

  node_->finish();
  makeNode(dir.path());
  walkFused(10);
  EXPECT_EQ(poses_.back().level, 1);
  EXPECT_EQ(poses_.back().status, lidar_pose_t::STATUS_GOOD);
  control(rubble::lidar_control_t::STATE_M, 0, 1);
  walkFused(5);
  control(rubble::lidar_control_t::STATE_R);
  walkFused(10);
  EXPECT_EQ(poses_.back().level, 0);
  EXPECT_EQ(poses_.back().status, lidar_pose_t::STATUS_GOOD);
  EXPECT_LT(error(), kOneCell);
  node_->finish();
  EXPECT_EQ(tilesOf(0), ground);
  for (const std::int32_t level : {-1, 64}) {
    control(rubble::lidar_control_t::STATE_H, 0, level);
    walk(1);
  }
  EXPECT_EQ(bus_->received().at(lcm_io::channel::kLidarControl).errors, 2);
}

TEST_F(SlamLidarNodeTest, SilenceOfControlStopsWriting) {
  control(rubble::lidar_control_t::STATE_H, std::numeric_limits<std::int64_t>::max());
  walk(30);
  control_.reset();
  passTime(600'000);
  walk(1);
  const std::int64_t revision = mapRevision();
  walk(30);
  EXPECT_EQ(mapRevision(), revision);
  EXPECT_EQ(node_->status().state, "unconfirmed");
  EXPECT_EQ(poses_.back().flags & lidar_pose_t::FLAG_WRITTEN, 0);
}

TEST_F(SlamLidarNodeTest, BadScansAreRefusedAndCounted) {
  walk(10);
  const std::size_t good = poses_.size();
  auto scan = roomScan(now_ - 5'000'000, T_world_lidar_);
  feed(lcm_io::channel::kScan, scan);
  passTime(100'000);
  EXPECT_EQ(bus_->received().at(lcm_io::channel::kScan).errors, 1) << "time going backwards";
  scan = roomScan(now_, T_world_lidar_);
  scan.radstep = std::numeric_limits<float>::quiet_NaN();
  feed(lcm_io::channel::kScan, scan);
  EXPECT_EQ(bus_->received().at(lcm_io::channel::kScan).errors, 2);
  feed(lcm_io::channel::kScan, rubble::command_t{});
  EXPECT_EQ(bus_->received().at(lcm_io::channel::kScan).errors, 3) << "another type";
  EXPECT_EQ(poses_.size(), good);

  scan = roomScan(now_ + 1000, T_world_lidar_);
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    constexpr std::array kBad = {std::numeric_limits<float>::quiet_NaN(),
                                 std::numeric_limits<float>::infinity(), 0.0F, -1.0F};
    scan.ranges[i] = kBad[i % kBad.size()];
  }
  feed(lcm_io::channel::kScan, scan);
  scan.utime += 1000;
  scan.nranges = 3;
  scan.ranges.resize(3);
  feed(lcm_io::channel::kScan, scan);
  now_ += 2000;
  walk(10);
  EXPECT_LT(error(), kOneCell);
}

TEST_F(SlamLidarNodeTest, ComesBackFromItsCheckpointWithTheSameMap) {
  const test::TempDir dir;
  makeNodeNow(dir.path());
  walk(80);
  const std::int64_t revision = mapRevision();
  node_->finish();
  makeNode(dir.path());
  T_world_lidar_ = T_world_lidar_ * Pose2{0.3, 0.1, 0.4};
  walk(10);
  EXPECT_GE(mapRevision(), revision);
  EXPECT_LT(error(), kOneCell);
  EXPECT_EQ(poses_.back().status, lidar_pose_t::STATUS_GOOD);
}

TEST_F(SlamLidarNodeTest, SavesAndLoadsOnCommand) {
  const test::TempDir dir;
  walk(40);
  rubble::command_t command;
  command.utime = now_;
  command.target = "slam_lidar";
  command.verb = "save";
  command.argument = dir.path() / "room.map";
  feed(lcm_io::channel::kCommand, command);
  const std::int64_t revision = mapRevision();
  walk(40);
  command.verb = "load";
  feed(lcm_io::channel::kCommand, command);
  command.argument = dir.path() / "missing.map";
  feed(lcm_io::channel::kCommand, command);
  EXPECT_EQ(bus_->received().at(lcm_io::channel::kCommand).errors, 1);
  EXPECT_NE(bus_->received().at(lcm_io::channel::kCommand).last_error.find("missing.map"), std::string::npos);
  now_ += kScanPeriod;
  feed(lcm_io::channel::kScan, roomScan(now_, T_world_lidar_));
  EXPECT_LE(mapRevision(), revision + 1);
}

}  // namespace
}  // namespace rubble
