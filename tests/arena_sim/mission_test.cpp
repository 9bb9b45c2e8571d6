#include "arena_sim/mission.h"

#include <gtest/gtest.h>

#include <bot_core/planar_lidar_t.hpp>
#include <cmath>
#include <map>
#include <rubble/ground_truth_t.hpp>

#include "arena.h"
#include "common/files.h"
#include "common/robot_config.h"
#include "common/trajectory.h"
#include "lcm_io/channels.h"
#include "lcm_io/log_file.h"
#include "support/error_text.h"
#include "support/temp_dir.h"

namespace rubble::arena_sim {
namespace {

using common::Pose2;

constexpr double kDuration = 20.0;

std::map<std::string, std::vector<lcm_io::LogEvent>> readByChannel(const std::filesystem::path& log) {
  std::map<std::string, std::vector<lcm_io::LogEvent>> channels;
  lcm_io::LogReader reader(log);
  common::Utime last = 0;
  while (auto event = reader.next()) {
    EXPECT_GE(event->utime, last);
    last = event->utime;
    channels[event->channel].push_back(std::move(*event));
  }
  return channels;
}

class MissionTest : public testing::Test {
 protected:
  std::filesystem::path write(std::uint64_t seed, bool with_odometry = true) {
    const auto out = folder_.path() / ("mission_" + std::to_string(count_++));
    writeFlatMission({seed, kDuration, with_odometry}, config(), out);
    return out;
  }

  /// Not the default robot's.
  static common::Config config() {
    common::Config config;
    config.addOverride("robot.lidar.sweep_time_s=0.02");
    config.addOverride("robot.plate.translation=[0.1, 0.05, 0.25]");
    return config;
  }

  test::TempDir folder_;
  int count_ = 0;
};

TEST_F(MissionTest, SameSeedSameBytesOtherSeedOtherBytes) {
  const auto one = write(4);
  const auto again = write(4);
  const auto other = write(5);
  for (const char* file : {"mission.lcm", "truth/body.tum", "truth/lidar.tum", "truth/map_0.pgm",
                           "truth/map_0.yaml", "top_view.png"}) {
    EXPECT_EQ(common::readFile(one / file), common::readFile(again / file)) << file;
  }
  EXPECT_NE(common::readFile(one / "mission.lcm"), common::readFile(other / "mission.lcm"));
  EXPECT_NE(common::readFile(one / "truth/map_0.pgm"), common::readFile(other / "truth/map_0.pgm"));
}

TEST_F(MissionTest, ChannelsComeAtTheirRates) {
  const auto channels = readByChannel(write(1) / "mission.lcm");
  ASSERT_EQ(channels.size(), 4U);
  EXPECT_NEAR(static_cast<double>(channels.at("SCAN").size()), 40.0 * kDuration, 1.0);
  EXPECT_NEAR(static_cast<double>(channels.at("STABILIZER").size()), 50.0 * kDuration, 1.0);
  EXPECT_NEAR(static_cast<double>(channels.at("ODOMETRY").size()), 50.0 * kDuration, 1.0);
  EXPECT_EQ(channels.at("GROUND_TRUTH").size(), 2 * channels.at("SCAN").size());
  for (const auto& [channel, events] : channels) {
    const lcm_io::ChannelInfo* info = lcm_io::findChannel(channel);
    ASSERT_NE(info, nullptr) << channel;
    EXPECT_EQ(info->channel_class, lcm_io::ChannelClass::kSource) << channel;
  }
}

TEST_F(MissionTest, WithoutOdometryAllElseIsTheSame) {
  auto with = readByChannel(write(1) / "mission.lcm");
  const auto without = readByChannel(write(1, false) / "mission.lcm");
  EXPECT_FALSE(without.contains("ODOMETRY"));
  with.erase("ODOMETRY");
  ASSERT_EQ(with.size(), without.size());
  for (const auto& [channel, events] : without) {
    ASSERT_EQ(events.size(), with[channel].size());
    for (std::size_t i = 0; i < events.size(); ++i) {
      ASSERT_EQ(events[i].data, with[channel][i].data) << channel;
    }
  }
}

/// T_world_lidar between two true poses.
Pose2 between(const common::StampedPose& a, const common::StampedPose& b, common::Utime utime) {
  const double share = static_cast<double>(utime - a.utime) / static_cast<double>(b.utime - a.utime);
  const auto yawOf = [](const common::StampedPose& p) {
    return common::rpyFromRotation(p.T_a_b.linear()).yaw;
  };
  const Eigen::Vector3d p = a.T_a_b.translation() + share * (b.T_a_b.translation() - a.T_a_b.translation());
  return {p.x(), p.y(), yawOf(a) + share * common::wrapAngle(yawOf(b) - yawOf(a))};
}

TEST_F(MissionTest, ScansProjectedWithTheTruthLieOnTheWalls) {
  const auto out = write(2);
  const Arena arena = makeArena(2);
  const auto truth = common::readTum(out / "truth/lidar.tum");
  const auto scans = readByChannel(out / "mission.lcm").at("SCAN");
  ASSERT_EQ(truth.size(), scans.size());
  const double sweep_us = config().read<common::RobotConfig>("robot", arenaRobot()).lidar_sweep_time_s * 1e6;
  double squares = 0.0;
  int n = 0;
  for (std::size_t k = 0; k + 1 < scans.size(); k += 20) {
    const auto scan = lcm_io::decode<bot_core::planar_lidar_t>(scans[k].data);
    ASSERT_EQ(scan.nranges, 1081);
    ASSERT_EQ(scan.utime, truth[k].utime);
    for (std::size_t i = 0; i < scan.ranges.size(); i += 10) {
      const auto range = static_cast<double>(scan.ranges[i]);
      if (!std::isfinite(range)) {
        continue;
      }
      const auto utime = scan.utime + std::llround(sweep_us * static_cast<double>(i) / scan.nranges);
      const double angle =
          static_cast<double>(scan.rad0) + static_cast<double>(i) * static_cast<double>(scan.radstep);
      const Eigen::Vector2d p_world = between(truth[k], truth[k + 1], utime) *
                                      Eigen::Vector2d(range * std::cos(angle), range * std::sin(angle));
      double off = 1e9;
      for (const Segment& segment : arena.segments) {
        off = std::min(off, distanceTo(segment, p_world));
      }
      ASSERT_LT(off, 0.06);
      squares += off * off;
      ++n;
    }
  }
  EXPECT_LT(std::sqrt(squares / n), 0.011);
}

TEST_F(MissionTest, TruthInTheLogIsTheTruthInTheFiles) {
  const auto out = write(3);
  const auto body = common::readTum(out / "truth/body.tum");
  const auto lidar = common::readTum(out / "truth/lidar.tum");
  std::map<std::string, std::size_t> seen;
  const auto channels = readByChannel(out / "mission.lcm");
  for (const auto& event : channels.at("GROUND_TRUTH")) {
    const auto truth = lcm_io::decode<rubble::ground_truth_t>(event.data);
    const auto& file = truth.frame == "body" ? body : lidar;
    const common::StampedPose& pose = file.at(seen[truth.frame]++);
    ASSERT_EQ(pose.utime, truth.utime);
    ASSERT_NEAR(pose.T_a_b.translation().x(), truth.p_world_frame[0], 1e-8);
    ASSERT_NEAR(pose.T_a_b.translation().z(), truth.p_world_frame[2], 1e-8);
  }
  EXPECT_EQ(seen, (std::map<std::string, std::size_t>{{"body", body.size()}, {"lidar", lidar.size()}}));
  EXPECT_LT((body.back().T_a_b.translation() - body.front().T_a_b.translation()).norm(), 0.05);
  EXPECT_NEAR(lidar.front().T_a_b.translation().z(), 0.30, 1e-9);
}

TEST_F(MissionTest, BadInputIsNamed) {
  const auto errorOf = [&](const MissionOptions& options, const char* assignment,
                           const std::filesystem::path& out) {
    common::Config config;
    if (assignment != nullptr) {
      config.addOverride(assignment);
    }
    return test::errorOf([&] { writeFlatMission(options, config, out); });
  };
  const auto out = folder_.path() / "out";
  EXPECT_NE(errorOf({1, 5.0}, nullptr, out).find("too short"), std::string::npos);
  EXPECT_NE(errorOf({}, nullptr, "/proc/none").find("/proc/none"), std::string::npos);
  EXPECT_NE(errorOf({}, "robot.lidar.rpy=[0.1, 0, 0]", out).find("robot.lidar.rpy"), std::string::npos);
}

}  // namespace
}  // namespace rubble::arena_sim
