#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/files.h"
#include "common/geometry.h"
#include "common/trajectory.h"
#include "lcm_io/log_file.h"
#include "support/child_process.h"
#include "support/lcm_url.h"
#include "support/recordings.h"
#include "support/shell.h"
#include "support/temp_dir.h"
#include "support/wait_until.h"

// The processes as processes: a log is played over udpm, the console logs, and what it logged is held to
// replay.

namespace rubble {
namespace {

const std::string kBin = std::string(RUBBLE_BIN_DIR) + "/";
const std::vector<std::string> kOthers = {"rubble-camera",    "rubble-lidar",  "rubble-stabilizer",
                                          "rubble-slam-mono", "rubble-fusion", "rubble-recognizer"};

/// Exit status after SIGTERM.
int terminate(test::ChildProcess& process) {
  process.signal(SIGTERM);
  return process.wait().value_or(-1);
}

class LiveTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    dir_ = std::make_unique<test::TempDir>();
    const auto made = test::shell(
        kBin + "rubble arena --mission flat --seed 5 --duration 20 --without-camera --no-cache --out " +
        path("mission"));
    ASSERT_EQ(made.status, 0) << made.output;
    const auto replayed =
        test::shell(kBin + "rubble replay " + path("mission/mission.lcm") + " --out " + path("replayed"));
    ASSERT_EQ(replayed.status, 0) << replayed.output;
  }
  static void TearDownTestSuite() { dir_.reset(); }
  static std::string path(const std::string& name) { return dir_->path() / name; }

  std::unique_ptr<test::ChildProcess> start(const std::string& program, std::vector<std::string> more = {}) {
    std::vector<std::string> arguments = {kBin + program, "--lcm-url", url_, "--config",
                                          path("mission/robot.yaml")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return std::make_unique<test::ChildProcess>(arguments);
  }
  std::unique_ptr<test::ChildProcess> startConsole(const std::string& log_dir) {
    return start("rubble-console", {"--set", "ops_console.log_dir=" + path(log_dir)});
  }
  test::ShellResult play(const std::string& log, const std::string& wait_for) const {
    return test::shell(kBin + "rubble play " + log + " --lcm-url '" + url_ + "' --wait-for " + wait_for);
  }
  static std::string onlyLog(const std::string& log_dir) {
    std::string log;
    for (const auto& entry : std::filesystem::directory_iterator(path(log_dir))) {
      if (entry.path().extension() == ".lcm") {
        EXPECT_TRUE(log.empty()) << "more than one log";
        log = entry.path();
      }
    }
    EXPECT_FALSE(log.empty()) << "no log";
    return log;
  }
  static void expectSamePath(const std::string& a, const std::string& b) {
    const common::Trajectory left = common::readTum(path(a) + "/trajectory_lidar.tum");
    const common::Trajectory right = common::readTum(path(b) + "/trajectory_lidar.tum");
    ASSERT_EQ(left.size(), right.size()) << "a scan was dropped";
    for (std::size_t i = 0; i < left.size(); ++i) {
      ASSERT_EQ(left[i].utime, right[i].utime);
      const common::Pose3 T = left[i].T_a_b.inverse() * right[i].T_a_b;
      EXPECT_LT(T.translation().norm(), 0.01) << "at " << left[i].utime;
      EXPECT_LT(Eigen::AngleAxisd(T.linear()).angle(), 0.2 * M_PI / 180.0) << "at " << left[i].utime;
    }
  }

  const std::string url_ = test::privateLcmUrl();
  static inline std::unique_ptr<test::TempDir> dir_;
};

TEST_F(LiveTest, TheWholeGraphGivesReplaysTrajectoryAndItsLogGivesItAgain) {
  RUBBLE_NEEDS_MULTICAST();
  const auto console = startConsole("log");
  const auto slam = start("rubble-slam-lidar");
  std::vector<std::unique_ptr<test::ChildProcess>> others;
  for (const std::string& program : kOthers) {
    // A camera of this machine is not meant.
    others.push_back(start(program, {"--set", "camera.device=/dev/no-camera"}));
  }
  const auto played = play(path("mission/mission.lcm"),
                           "slam_lidar,ops_console,slam_mono,fusion,recognizer,camera,lidar,stabilizer");
  ASSERT_EQ(played.status, 0) << played.output;
  for (const auto& process : others) {
    EXPECT_EQ(terminate(*process), 0);
  }
  EXPECT_EQ(terminate(*slam), 0);
  EXPECT_EQ(terminate(*console), 0);

  const std::string log = onlyLog("log");
  const auto exported = test::shell(kBin + "rubble export results " + log + " --out " + path("live"));
  ASSERT_EQ(exported.status, 0) << exported.output;
  expectSamePath("live", "replayed");
  const auto again = test::shell(kBin + "rubble replay " + log + " --out " + path("again"));
  ASSERT_EQ(again.status, 0) << again.output;
  expectSamePath("again", "live");
}

TEST_F(LiveTest, KilledGridSlamComesBackWithItsMap) {
  RUBBLE_NEEDS_MULTICAST();
  const auto console = startConsole("log_killed");
  const std::vector<std::string> state = {"--state-dir", path("state"), "--set",
                                          "slam_lidar.checkpoint_period=1.0"};
  auto slam = start("rubble-slam-lidar", state);
  test::ChildProcess player({kBin + "rubble", "play", path("mission/mission.lcm"), "--lcm-url", url_,
                             "--wait-for", "slam_lidar,ops_console"});
  ASSERT_TRUE(test::waitUntil([&] { return std::filesystem::exists(path("state/slam_lidar.checkpoint")); }));
  const auto first = std::filesystem::last_write_time(path("state/slam_lidar.checkpoint"));
  ASSERT_TRUE(test::waitUntil([&] {
    return std::filesystem::last_write_time(path("state/slam_lidar.checkpoint")) - first >=
           std::chrono::seconds(8);
  }));
  slam->signal(SIGKILL);
  EXPECT_EQ(slam->wait(), 128 + SIGKILL);
  slam = start("rubble-slam-lidar", state);
  EXPECT_EQ(player.wait(std::chrono::seconds(60)), 0);
  EXPECT_EQ(terminate(*slam), 0);
  EXPECT_EQ(terminate(*console), 0);

  const auto exported =
      test::shell(kBin + "rubble export results " + onlyLog("log_killed") + " --out " + path("killed"));
  ASSERT_EQ(exported.status, 0) << exported.output;
  const auto map = test::shell(kBin + "rubble eval map " + path("killed/map_0.yaml") + " " +
                               path("replayed/map_0.yaml") + " --tolerance 0.1 --json");
  ASSERT_EQ(map.status, 0) << map.output;
  const auto json = nlohmann::json::parse(map.output);
  EXPECT_GT(json.at("precision").get<double>(), 0.95) << map.output;
  EXPECT_GT(json.at("recall").get<double>(), 0.95) << map.output;
  const common::StampedPose live = common::readTum(path("killed/trajectory_lidar.tum")).back();
  const common::StampedPose replayed = common::readTum(path("replayed/trajectory_lidar.tum")).back();
  EXPECT_LT((live.T_a_b.translation() - replayed.T_a_b.translation()).norm(), 0.05);
}

TEST_F(LiveTest, MonocularSlamFollowsTheCameraAndTheConsolesLogHoldsItsPath) {
  RUBBLE_NEEDS_MULTICAST();
  RUBBLE_NEEDS_RECORDINGS(data);
  const std::filesystem::path folder = data / "mono" / "euroc_v101_90";
  const auto imported =
      test::shell(kBin + "rubble import tum " + folder.string() + " --out " + path("euroc.lcm"));
  ASSERT_EQ(imported.status, 0) << imported.output;
  const auto console = startConsole("log_mono");
  const auto slam = start("rubble-slam-mono");
  const auto played = play(path("euroc.lcm"), "slam_mono,ops_console");
  ASSERT_EQ(played.status, 0) << played.output;
  EXPECT_EQ(terminate(*slam), 0);
  EXPECT_EQ(terminate(*console), 0);

  const auto exported =
      test::shell(kBin + "rubble export results " + onlyLog("log_mono") + " --out " + path("live_mono"));
  ASSERT_EQ(exported.status, 0) << exported.output;
  const auto csv = common::readFile(path("live_mono/poses.csv"));
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1 + 90) << "a pose for every picture";
  const auto ate = test::shell(kBin + "rubble eval ate " + path("live_mono/trajectory_mono_final.tum") + " " +
                               (folder / "groundtruth.txt").string() + " --align sim3 --json");
  ASSERT_EQ(ate.status, 0) << ate.output;
  const auto json = nlohmann::json::parse(ate.output);
  EXPECT_GE(json.at("poses").get<int>(), 70) << ate.output;
  EXPECT_LT(json.at("translation_rmse_m").get<double>(), 0.02) << ate.output;
}

/// With pictures: vision, LiDAR and fusion at once.
class LiveFusionTest : public LiveTest {
 protected:
  static void SetUpTestSuite() {
    dir_ = std::make_unique<test::TempDir>();
    const auto made = test::shell(kBin +
                                  "rubble arena --mission flat --seed 1 --duration 20 --no-cache --set "
                                  "arena_sim.camera.samples=1 --out " +
                                  path("mission"));
    ASSERT_EQ(made.status, 0) << made.output;
    const auto replayed =
        test::shell(kBin + "rubble replay " + path("mission/mission.lcm") + " --out " + path("replayed"));
    ASSERT_EQ(replayed.status, 0) << replayed.output;
  }

  /// How the fused path that the console logged differs from replay's.
  struct Difference {
    std::size_t reference = 0;
    std::size_t compared = 0;
    std::size_t apart = 0;  // By more than 3 cm or 0.5 degrees.
    double largest = 0.0;   // m
    double last = 0.0;      // m, at the end
  };
  static Difference differenceFromReplay(const std::string& log_dir) {
    const auto exported =
        test::shell(kBin + "rubble export results " + onlyLog(log_dir) + " --out " + path(log_dir + "_out"));
    EXPECT_EQ(exported.status, 0) << exported.output;
    const common::Trajectory live = common::readTum(path(log_dir + "_out/trajectory_fused.tum"));
    const common::Trajectory reference = common::readTum(path("replayed/trajectory_fused.tum"));
    Difference difference;
    difference.reference = reference.size();
    for (const common::StampedPose& pose : live) {
      const auto same = std::find_if(reference.begin(), reference.end(),
                                     [&](const common::StampedPose& r) { return r.utime == pose.utime; });
      if (same != reference.end()) {
        const common::Pose3 T = same->T_a_b.inverse() * pose.T_a_b;
        ++difference.compared;
        difference.last = T.translation().norm();
        difference.largest = std::max(difference.largest, difference.last);
        difference.apart +=
            difference.last > 0.03 || Eigen::AngleAxisd(T.linear()).angle() > 0.5 * M_PI / 180.0 ? 1 : 0;
      }
    }
    return difference;
  }
};

TEST_F(LiveFusionTest, FusedPathIsReplays) {
  RUBBLE_NEEDS_MULTICAST();
  const auto console = startConsole("log_seen");
  std::vector<std::unique_ptr<test::ChildProcess>> processes;
  for (const char* program : {"rubble-slam-lidar", "rubble-slam-mono", "rubble-fusion"}) {
    processes.push_back(start(program));
  }
  const auto played = play(path("mission/mission.lcm"), "slam_lidar,ops_console,slam_mono,fusion");
  ASSERT_EQ(played.status, 0) << played.output;
  for (const auto& process : processes) {
    EXPECT_EQ(terminate(*process), 0);
  }
  EXPECT_EQ(terminate(*console), 0);

  const Difference difference = differenceFromReplay("log_seen");
  EXPECT_GT(difference.compared, difference.reference * 95 / 100);
  // Which scan is the last before a picture is chance, and in the first second the LiDAR's map is one scan.
  EXPECT_LE(difference.apart, difference.compared / 50);
  EXPECT_LT(difference.largest, 0.1);
}

TEST_F(LiveFusionTest, KilledFusionComesBackToItsWorld) {
  RUBBLE_NEEDS_MULTICAST();
  const auto console = startConsole("log_killed_fusion");
  const std::filesystem::path checkpoint = path("state/fusion.checkpoint");
  const std::vector<std::string> state = {"--state-dir", path("state"), "--set",
                                          "fusion.checkpoint_period=1.0"};
  std::vector<std::unique_ptr<test::ChildProcess>> others;
  others.push_back(start("rubble-slam-lidar"));
  others.push_back(start("rubble-slam-mono"));
  auto fusion = start("rubble-fusion", state);
  test::ChildProcess player({kBin + "rubble", "play", path("mission/mission.lcm"), "--lcm-url", url_,
                             "--wait-for", "slam_lidar,ops_console,slam_mono,fusion"});
  ASSERT_TRUE(test::waitUntil([&] { return std::filesystem::exists(checkpoint); }));
  const auto first = std::filesystem::last_write_time(checkpoint);
  ASSERT_TRUE(test::waitUntil(
      [&] { return std::filesystem::last_write_time(checkpoint) - first >= std::chrono::seconds(9); }));
  fusion->signal(SIGKILL);
  EXPECT_EQ(fusion->wait(), 128 + SIGKILL);
  fusion = start("rubble-fusion", state);
  EXPECT_EQ(player.wait(std::chrono::seconds(60)), 0);
  EXPECT_EQ(terminate(*fusion), 0);
  for (const auto& process : others) {
    EXPECT_EQ(terminate(*process), 0);
  }
  EXPECT_EQ(terminate(*console), 0);
  const Difference difference = differenceFromReplay("log_killed_fusion");
  EXPECT_GT(difference.compared, difference.reference * 85 / 100)
      << "a restart takes less than a second or two";
  EXPECT_LT(difference.last, 0.05);
}

}  // namespace
}  // namespace rubble
