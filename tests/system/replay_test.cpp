#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "common/files.h"
#include "lcm_io/log_file.h"
#include "support/shell.h"
#include "support/temp_dir.h"

namespace rubble {
namespace {

const std::string kRubble = std::string(RUBBLE_BIN_DIR) + "/rubble";

/// One short mission for all tests of the suite.
class ReplayTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    dir_ = std::make_unique<test::TempDir>();
    const auto made = test::shell(
        kRubble + " arena --mission flat --seed 3 --duration 20 --without-camera --no-cache --out " +
        path("mission"));
    ASSERT_EQ(made.status, 0) << made.output;
  }
  static void TearDownTestSuite() { dir_.reset(); }

  static std::string path(const std::string& name) { return dir_->path() / name; }
  static test::ShellResult replay(const std::string& log, const std::string& out,
                                  const std::string& more = "") {
    return test::shell(kRubble + " replay " + path(log) + " --out " + path(out) + " " + more);
  }
  static void expectSameFiles(const std::string& a, const std::string& b) {
    for (const char* file :
         {"trajectory_lidar.tum", "trajectory_lidar_final.tum", "trajectory_mono.tum",
          "trajectory_mono_final.tum", "poses.csv", "map_0.pgm", "map_0.yaml", "map_0.png", "health.json"}) {
      EXPECT_EQ(common::readFile(path(a) + "/" + file), common::readFile(path(b) + "/" + file)) << file;
    }
  }

  static inline std::unique_ptr<test::TempDir> dir_;
};

TEST_F(ReplayTest, TwoRunsWriteTheSameBytes) {
  ASSERT_EQ(replay("mission/mission.lcm", "a").status, 0);
  ASSERT_EQ(replay("mission/mission.lcm", "b").status, 0);
  expectSameFiles("a", "b");
  const auto timing = nlohmann::json::parse(common::readFile(path("a") + "/timing.json"));
  EXPECT_GT(timing.at("slam_lidar").at("total").at("count").get<int>(), 700);
  EXPECT_GT(timing.at("slam_lidar").at("match").at("p95_ms").get<double>(), 0.0);
}

TEST_F(ReplayTest, GroundTruthIsNotUsed) {
  std::filesystem::create_directories(path("blind"));
  std::filesystem::copy_file(path("mission/robot.yaml"), path("blind/robot.yaml"));
  {
    lcm_io::LogReader in(path("mission/mission.lcm"));
    lcm_io::LogWriter out(path("blind/mission.lcm"));
    while (const auto event = in.next()) {
      if (event->channel != "GROUND_TRUTH") {
        out.write(event->utime, event->channel, event->data);
      }
    }
  }
  ASSERT_EQ(replay("mission/mission.lcm", "seeing").status, 0);
  ASSERT_EQ(replay("blind/mission.lcm", "blindly").status, 0);
  expectSameFiles("seeing", "blindly");
}

TEST_F(ReplayTest, FollowsTheTruth) {
  ASSERT_EQ(replay("mission/mission.lcm", "truth").status, 0);
  const auto ate = test::shell(kRubble + " eval ate " + path("truth/trajectory_lidar.tum") + " " +
                               path("mission/truth/lidar.tum") + " --align start --json");
  ASSERT_EQ(ate.status, 0) << ate.output;
  EXPECT_LT(nlohmann::json::parse(ate.output).at("translation_rmse_m").get<double>(), 0.05) << ate.output;
  const auto map = test::shell(kRubble + " eval map " + path("truth/map_0.yaml") + " " +
                               path("mission/truth/map_0.yaml") + " --json");
  ASSERT_EQ(map.status, 0) << map.output;
  EXPECT_GT(nlohmann::json::parse(map.output).at("precision").get<double>(), 0.9) << map.output;
}

TEST_F(ReplayTest, BadInputIsOneClearLine) {
  const auto unknown_key = replay("mission/mission.lcm", "x", "--set slam_lidar.mpa.cell_size=0.1");
  EXPECT_EQ(unknown_key.status, 1);
  EXPECT_NE(unknown_key.output.find("did you mean `map`"), std::string::npos) << unknown_key.output;
  const auto missing = replay("nothing.lcm", "x");
  EXPECT_EQ(missing.status, 1);
  EXPECT_NE(missing.output.find("nothing.lcm"), std::string::npos) << missing.output;
  EXPECT_EQ(replay("mission/robot.yaml", "x").status, 1);
  EXPECT_EQ(replay("mission/mission.lcm", "x", "--only nobody").status, 1);
  EXPECT_EQ(replay("mission/mission.lcm", "x", "--bogus").status, 2);
}

TEST_F(ReplayTest, ACutLogIsReplayedUpToTheCut) {
  auto bytes = common::readFile(path("mission/mission.lcm"));
  bytes.resize(bytes.size() / 2 + 1);
  common::writeFileAtomically(path("cut.lcm"), bytes);
  const auto cut = replay("cut.lcm", "cut", "--config " + path("mission/robot.yaml"));
  EXPECT_EQ(cut.status, 0);
  EXPECT_NE(cut.output.find("cut off"), std::string::npos) << cut.output;
}

}  // namespace
}  // namespace rubble
