#include "support/recordings.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "support/shell.h"
#include "support/temp_dir.h"

// SLAM on the real recordings, whole logs, through the command line. The bars are the issue's; the figures
// reached stand in docs/slam_lidar.md.

namespace rubble {
namespace {

const std::string kRubble = std::string(RUBBLE_BIN_DIR) + "/rubble";

struct Case {
  const char* log;
  bool odometry;
  double mean_m;
  double median_m;
};

void PrintTo(const Case& c, std::ostream* out) {
  *out << c.log << (c.odometry ? " with odometry" : " without prior");
}

class RelationsTest : public testing::TestWithParam<Case> {};

TEST_P(RelationsTest, StaysWithinTheBar) {
  RUBBLE_NEEDS_RECORDINGS(data);
  const Case& c = GetParam();
  const std::filesystem::path folder = data / "lidar" / c.log;
  const test::TempDir dir;
  const std::string log = dir.path() / "log.lcm";
  const std::string out = dir.path() / "out";
  const auto imported = test::shell(kRubble + " import carmen " + (folder / c.log).string() +
                                    ".clf.bz2 --out " + log + (c.odometry ? "" : " --without-odometry"));
  ASSERT_EQ(imported.status, 0) << imported.output;
  const auto replayed = test::shell(kRubble + " replay " + log + " --out " + out);
  ASSERT_EQ(replayed.status, 0) << replayed.output;
  const auto evaluated = test::shell(kRubble + " eval relations " + out + "/trajectory_lidar.tum " +
                                     (folder / c.log).string() + ".relations --json");
  ASSERT_EQ(evaluated.status, 0) << evaluated.output;
  const auto json = nlohmann::json::parse(evaluated.output);
  EXPECT_LE(json.at("translation_mean_m").get<double>(), c.mean_m);
  EXPECT_LE(json.at("translation_median_m").get<double>(), c.median_m);
  EXPECT_EQ(json.at("matched"), json.at("total"));
}

INSTANTIATE_TEST_SUITE_P(Recordings, RelationsTest,
                         testing::Values(Case{"fr079", true, 0.040, 0.035}, Case{"fr079", false, 0.10, 0.10},
                                         Case{"aces", true, 0.45, 0.035}, Case{"aces", false, 1.0, 1.0}));

TEST(MonoRecordingsTest, EurocIsTrackedWithinTheBar) {
  RUBBLE_NEEDS_RECORDINGS(data);
  const std::filesystem::path folder = data / "mono" / "euroc_v101_90";
  const test::TempDir dir;
  const std::string log = dir.path() / "log.lcm";
  const std::string out = dir.path() / "out";
  const auto imported = test::shell(kRubble + " import tum " + folder.string() + " --out " + log);
  ASSERT_EQ(imported.status, 0) << imported.output;
  const auto replayed = test::shell(kRubble + " replay " + log + " --out " + out);
  ASSERT_EQ(replayed.status, 0) << replayed.output;
  for (const char* file : {"trajectory_mono.tum", "trajectory_mono_final.tum"}) {
    const auto evaluated = test::shell(kRubble + " eval ate " + out + "/" + file + " " +
                                       (folder / "groundtruth.txt").string() + " --align sim3 --json");
    ASSERT_EQ(evaluated.status, 0) << evaluated.output;
    const auto json = nlohmann::json::parse(evaluated.output);
    EXPECT_LE(json.at("translation_rmse_m").get<double>(), 0.02) << file;
    EXPECT_GE(json.at("poses").get<int>(), 70) << file;
  }
}

}  // namespace
}  // namespace rubble
