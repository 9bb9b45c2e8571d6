#include "arena_sim/mission.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bot_core/image_t.hpp>
#include <bot_core/planar_lidar_t.hpp>
#include <cmath>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <rubble/camera_info_t.hpp>
#include <rubble/ground_truth_t.hpp>
#include <rubble/revisit_request_t.hpp>
#include <rubble/stabilizer_t.hpp>
#include <set>
#include <utility>

#include "common/files.h"
#include "common/trajectory.h"
#include "lcm_io/channels.h"
#include "lcm_io/log_file.h"
#include "lcm_io/replay_hub.h"
#include "support/error_text.h"
#include "support/temp_dir.h"

namespace rubble::arena_sim {
namespace {

constexpr double kDuration = 20.0;

using Channels = std::map<std::string, std::vector<lcm_io::LogEvent>>;

Channels readByChannel(const std::filesystem::path& log) {
  Channels channels;
  lcm_io::LogReader reader(log);
  common::Utime last = 0;
  while (auto event = reader.next()) {
    EXPECT_GE(event->utime, last);
    last = event->utime;
    channels[event->channel].push_back(std::move(*event));
  }
  return channels;
}

/// Small and coarse, so that it is quick.
class MissionTest : public testing::Test {
 protected:
  static MissionOptions options(std::uint64_t seed, bool with_camera = false) {
    MissionOptions options;
    options.seed = seed;
    options.duration_s = kDuration;
    options.with_camera = with_camera;
    return options;
  }

  std::filesystem::path write(const MissionOptions& options, const std::vector<std::string>& more = {}) {
    common::Config config;
    for (const char* assignment :
         {"arena_sim.picture_scale=0.1", "arena_sim.camera.samples=1", "robot.camera.rate=3",
          "arena_sim.camera.texture_budget=0.5", "arena_sim.lidar.beams=271", "arena_sim.lidar.rate=20"}) {
      config.addOverride(assignment);
    }
    for (const std::string& assignment : more) {
      config.addOverride(assignment);
    }
    const auto out = folder_.path() / ("mission_" + std::to_string(count_++));
    writeMission(options, config, out);
    return out;
  }

  test::TempDir folder_;
  int count_ = 0;
};

TEST_F(MissionTest, SameSeedSameBytesOtherSeedOtherBytes) {
  const auto one = write(options(4, true));
  const auto again = write(options(4, true));
  const auto other = write(options(5));
  for (const char* file : {"mission.lcm", "robot.yaml", "arena_sim.yaml", "truth/body.tum",
                           "truth/camera.tum", "truth/lidar.tum", "truth/states.csv", "truth/objects.csv",
                           "truth/map_0.pgm", "truth/map_0.yaml", "top_view.png", "preview.png"}) {
    EXPECT_EQ(common::readFile(one / file), common::readFile(again / file)) << file;
  }
  EXPECT_NE(common::readFile(one / "truth/objects.csv"), common::readFile(other / "truth/objects.csv"));
  EXPECT_NE(common::readFile(one / "truth/map_0.pgm"), common::readFile(other / "truth/map_0.pgm"));
}

TEST_F(MissionTest, ChannelsComeAtTheirRatesWithTruthForEachReport) {
  const auto out = write(options(1, true));
  const Channels channels = readByChannel(out / "mission.lcm");
  const auto count = [&](const char* channel) { return static_cast<double>(channels.at(channel).size()); };
  const double seconds = count("STABILIZER") / 100.0;
  EXPECT_GT(seconds, 0.6 * kDuration);
  EXPECT_LE(seconds, kDuration);
  EXPECT_NEAR(count("SCAN"), 20.0 * seconds, 1.5);
  EXPECT_NEAR(count("ODOMETRY"), 50.0 * seconds, 1.5);
  EXPECT_NEAR(count("CAMERA"), 3.0 * seconds, 1.5);
  EXPECT_NEAR(count("CAMERA_INFO"), 5.0 * seconds, 1.5);
  EXPECT_EQ(count("GROUND_TRUTH"), 2 * (count("SCAN") + count("CAMERA")));
  for (const auto& [channel, events] : channels) {
    const lcm_io::ChannelInfo* info = lcm_io::findChannel(channel);
    ASSERT_NE(info, nullptr) << channel;
    EXPECT_EQ(info->channel_class, lcm_io::ChannelClass::kSource) << channel;
  }
}

TEST_F(MissionTest, PicturesAreWhatCameraInfoSays) {
  const Channels channels = readByChannel(write(options(1, true)) / "mission.lcm");
  const auto info = lcm_io::decode<rubble::camera_info_t>(channels.at("CAMERA_INFO").front().data);
  EXPECT_EQ(info.width, 64);
  EXPECT_EQ(info.height, 48);
  EXPECT_NEAR(info.cx, 31.5, 1e-9) << "the middle stays the middle";
  const auto image = lcm_io::decode<bot_core::image_t>(channels.at("CAMERA").front().data);
  EXPECT_EQ(cv::imdecode(image.data, cv::IMREAD_COLOR).size(), cv::Size(64, 48));
  ASSERT_EQ(image.nmetadata, 1);
  EXPECT_EQ(image.metadata[0].key, "exposure_us");
}

TEST_F(MissionTest, LeavingASensorOutChangesNoOther) {
  Channels with = readByChannel(write(options(1)) / "mission.lcm");
  MissionOptions without_odometry = options(1);
  without_odometry.with_odometry = false;
  const Channels without = readByChannel(write(without_odometry) / "mission.lcm");
  EXPECT_FALSE(without.contains("ODOMETRY"));
  EXPECT_FALSE(with.contains("CAMERA"));
  with.erase("ODOMETRY");
  ASSERT_EQ(with.size(), without.size());
  for (const auto& [channel, events] : without) {
    ASSERT_EQ(events.size(), with[channel].size());
    for (std::size_t i = 0; i < events.size(); ++i) {
      ASSERT_EQ(events[i].data, with[channel][i].data) << channel;
    }
  }
}

TEST_F(MissionTest, TruthInTheLogIsTheTruthInTheFiles) {
  const auto out = write(options(3, true));
  std::map<std::string, common::Trajectory> files;
  std::map<std::string, std::set<common::Utime>> seen;
  for (const char* frame : {"body", "camera", "lidar"}) {
    files[frame] = common::readTum(out / "truth" / (std::string(frame) + ".tum"));
  }
  const Channels channels = readByChannel(out / "mission.lcm");
  for (const auto& event : channels.at("GROUND_TRUTH")) {
    const auto truth = lcm_io::decode<rubble::ground_truth_t>(event.data);
    const common::Trajectory& file = files.at(truth.frame);
    const auto pose = std::find_if(file.begin(), file.end(),
                                   [&](const common::StampedPose& p) { return p.utime == truth.utime; });
    ASSERT_NE(pose, file.end()) << truth.frame;
    ASSERT_NEAR(pose->T_a_b.translation().x(), truth.p_world_frame[0], 1e-8);
    ASSERT_NEAR(pose->T_a_b.translation().z(), truth.p_world_frame[2], 1e-8);
    seen[truth.frame].insert(truth.utime);
  }
  for (const auto& [frame, file] : files) {
    EXPECT_EQ(seen[frame].size(), file.size()) << frame;
  }
  EXPECT_LT((files["body"].back().T_a_b.translation() - files["body"].front().T_a_b.translation()).norm(),
            0.1);
  EXPECT_NEAR(files["lidar"].front().T_a_b.translation().z(), 0.30, 0.005);
}

TEST_F(MissionTest, DisturbancesReachTheLog) {
  const Channels channels = readByChannel(
      write(options(1), {"arena_sim.disturbances=[{kind: drop, channel: SCAN, at: 2, duration: 3}, "
                         "{kind: clock_offset, channel: ODOMETRY, at: 0, duration: 100, offset: 0.2}]"}) /
      "mission.lcm");
  double longest_gap = 0.0;
  const auto& scans = channels.at("SCAN");
  for (std::size_t i = 1; i < scans.size(); ++i) {
    longest_gap = std::max(longest_gap, common::secondsFromUtime(scans[i].utime - scans[i - 1].utime));
  }
  EXPECT_NEAR(longest_gap, 3.0, 0.11);
}

TEST_F(MissionTest, ACachedMissionIsTheSame) {
  MissionOptions cached = options(2);
  cached.cache = folder_.path() / "cache";
  const auto made = write(cached);
  const auto kept = write(cached);
  EXPECT_EQ(common::readFile(made / "mission.lcm"), common::readFile(kept / "mission.lcm"));
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(cached.cache), {}), 1);
  write(cached, {"arena_sim.lidar.range_sigma=0.02"});
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(cached.cache), {}), 2);
}

TEST_F(MissionTest, ARobotsCommandsMoveThePlate) {
  lcm_io::ReplayHub hub;
  lcm_io::Bus& node = hub.endpoint();
  node.subscribe<rubble::stabilizer_t>(lcm_io::channel::kStabilizer, [&](const auto& stabilizer) {
    rubble::stabilizer_command_t command{};
    command.utime = stabilizer.utime;
    command.valid_until_utime = stabilizer.utime + 100'000;
    command.roll = 0.1;
    command.pitch = -0.05;
    node.publish(lcm_io::channel::kStabilizerCommand, command);
  });
  RobotWish wish;
  hub.endpoint().subscribe<rubble::stabilizer_command_t>(lcm_io::channel::kStabilizerCommand,
                                                         [&](const auto& command) { wish.plate = command; });
  MissionOptions closed = options(1);
  closed.cache = folder_.path() / "cache";
  closed.make_robot = [&](const std::filesystem::path& robot_yaml) {
    EXPECT_TRUE(std::filesystem::exists(robot_yaml));
    return [&](const lcm_io::RawMessage& message) {
      hub.feed(message);
      return std::exchange(wish, {});
    };
  };
  const auto out = write(closed);
  EXPECT_FALSE(std::filesystem::exists(closed.cache));
  const Channels channels = readByChannel(out / "mission.lcm");
  EXPECT_FALSE(channels.contains("STABILIZER_COMMAND")) << "the log holds sources";
  const auto& reports = channels.at("STABILIZER");
  for (std::size_t i = 50; i < reports.size(); ++i) {
    const auto stabilizer = lcm_io::decode<rubble::stabilizer_t>(reports[i].data);
    ASSERT_NEAR(stabilizer.roll, 0.1, 0.005) << i;
    ASSERT_NEAR(stabilizer.pitch, -0.05, 0.005) << i;
    ASSERT_GT(stabilizer.command_utime, stabilizer.utime - 50'000) << i;
  }
}

TEST_F(MissionTest, ARobotIsTakenBackToTheKeyframesItAsksFor) {
  rubble::revisit_request_t request{};
  request.keyframes.resize(2);
  request.n = 2;
  MissionOptions closed = options(1);
  common::Utime begin = 0;
  closed.make_robot = [&](const std::filesystem::path&) {
    return [&](const lcm_io::RawMessage& message) {
      begin = begin == 0 ? message.receive_utime : begin;
      RobotWish wish;
      if (message.receive_utime - begin >= common::utimeFromSeconds(9.0) && request.utime == 0) {
        request.utime = message.receive_utime;
        request.keyframes[0].utime = begin + common::utimeFromSeconds(8.0);
        request.keyframes[1].utime = begin + common::utimeFromSeconds(3.0);
        wish.revisit = request;
      }
      return wish;
    };
  };
  const auto path = common::readTum(write(closed) / "truth" / "body.tum");
  const auto at = [&](double seconds) {
    const auto found =
        std::lower_bound(path.begin(), path.end(), begin + common::utimeFromSeconds(seconds),
                         [](const auto& pose, common::Utime utime) { return pose.utime < utime; });
    return Eigen::Vector3d(found->T_a_b.translation());
  };
  EXPECT_GT((at(9.0) - at(3.0)).norm(), 0.4);
  EXPECT_LT((at(16.25) - at(3.0)).norm(), 0.02) << "turning round, six seconds of the way, braking";
}

TEST_F(MissionTest, BadInputIsNamed) {
  const auto errorOf = [&](MissionOptions options, const std::string& assignment) {
    return test::errorOf([&] { write(options, {assignment}); });
  };
  MissionOptions soon = options(1);
  soon.duration_s = 5.0;
  EXPECT_NE(errorOf(soon, "arena_sim.picture_scale=1").find("too short"), std::string::npos);
  MissionOptions unknown = options(1);
  unknown.kind = "race";
  EXPECT_NE(errorOf(unknown, "arena_sim.picture_scale=1").find("`race`"), std::string::npos);
  EXPECT_NE(errorOf(options(1), "arena_sim.world.width=-3").find("arena_sim.world.width"), std::string::npos);
  EXPECT_NE(errorOf(options(1), "arena_sim.wrld.width=3").find("unknown key `wrld`"), std::string::npos);
  EXPECT_NE(test::errorOf([] { writeMission({}, {}, "/proc/none"); }).find("/proc/none"), std::string::npos);
}

}  // namespace
}  // namespace rubble::arena_sim
