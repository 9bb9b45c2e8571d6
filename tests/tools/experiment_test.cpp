#include "experiment.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "common/files.h"
#include "replay.h"
#include "small_arena.h"
#include "support/error_text.h"
#include "support/temp_dir.h"

namespace rubble::tools {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(ExperimentTest, SeedsAreListsAndRanges) {
  EXPECT_THAT(parseSeeds("7"), ElementsAre(7));
  EXPECT_THAT(parseSeeds("1..3"), ElementsAre(1, 2, 3));
  EXPECT_THAT(parseSeeds("9,2..3,5..5"), ElementsAre(9, 2, 3, 5));
  for (const char* bad : {"", "x", "3..1", "1..", "..2", "1,,2", "1,", "-1", "1..2..3", "1..100000", "2.5"}) {
    EXPECT_THAT(test::errorOf([&] { parseSeeds(bad); }), HasSubstr(" seed")) << bad;
  }
}

TEST(ExperimentTest, TheReportSaysWhatHalfAndNineTenthsOfTheSeedsReach) {
  std::vector<SeedScores> seeds;
  for (int i = 1; i <= 10; ++i) {
    SeedScores seed;
    seed.seed = static_cast<std::uint64_t>(i);
    seed.consistency['M'] = {.poses = i, .xy = 0.9, .z = 1.0, .attitude = 0.1 * i};
    seed.scores[1] = {0.01 * i,
                      0.001 * i,
                      0.1 * i,
                      0.9 + 0.01 * i,
                      0.5 + 0.01 * i,
                      0.7 + 0.01 * i,
                      0.8 + 0.01 * i,
                      0.6 + 0.01 * i,
                      0.01,
                      0.02,
                      2.5};
    seeds.push_back(seed);
  }
  const std::string report = experimentReport("What was run", seeds);
  EXPECT_THAT(
      report,
      AllOf(
          HasSubstr("# What was run\n"),
          HasSubstr("| **median** | lsm | 0.055 | 0.005 | 0.55 | 95.5 | 0.555 | 0.755 | 0.855 | 0.655 | 1.0 "
                    "| 2.0 | 2.5 |"),
          HasSubstr("| **90 % reach** | lsm | 0.090 | 0.009 | 0.90 | 92.0 | 0.520 | 0.720 | 0.820 | 0.620 | "
                    "1.0 | 2.0 | 2.5 |"),
          HasSubstr(
              "| 3 | lsm | 0.030 | 0.003 | 0.30 | 93.0 | 0.530 | 0.730 | 0.830 | 0.630 | 1.0 | 2.0 | 2.5 |"),
          HasSubstr("| 3 | grid SLAM alone | none | none | none | 0.0 | 0.000 | 0.000 | none | none | none | "
                    "none | none |"),
          HasSubstr("![lsm](seed_3/lsm/map_0.png)"), HasSubstr("| M | 55 | 90.0 | 100.0 | 70.0 |"),
          HasSubstr("| **all** | | | 0 / 0 | 0 |")));
}

TEST(ExperimentTest, ScoresEveryMethodOnTheSameMission) {
  const test::TempDir dir;
  ExperimentOptions options{smallMission(), {1}, dir.path(), smallArena()};
  runExperiment(options);
  const auto seed = dir.path() / "seed_1";
  for (const Method& method : kMethods) {
    const Score score = scoreResults(seed / method.name, seed / "mission", !method.with_fusion);
    EXPECT_LT(score.ate_rmse_m, 0.15) << method.name;
    EXPECT_LT(score.attitude_rmse_deg, 2.0) << method.name;
    EXPECT_GT(score.coverage, 0.95) << method.name;
    EXPECT_GT(score.map_precision, 0.85) << method.name;
    EXPECT_TRUE(std::filesystem::exists(seed / method.name / "map_0.png"));
  }
  EXPECT_TRUE(std::filesystem::exists(seed / "mission" / "truth" / "map_0.png"));
  EXPECT_FALSE(std::filesystem::exists(seed / "mission" / "mission.lcm"));
  const auto report = common::readFile(dir.path() / "report.md");
  EXPECT_THAT(std::string(report.begin(), report.end()), HasSubstr("| 1 | lsm-robust | 0."));
}

TEST(ExperimentTest, IsWhatAReplayOfTheLogSays) {
  const test::TempDir dir;
  runExperiment({smallMission(), {1}, dir.path(), smallArena()});
  const auto mission = dir.path() / "again";
  arena_sim::writeMission(smallMission(), smallArena(), mission);
  common::Config config = smallArena();
  config.addFile(mission / "robot.yaml");
  config.addOverride("fusion.mode=lsm-robust");
  replay({.log = mission / "mission.lcm", .out_dir = dir.path() / "replay", .only = {}, .config = config});
  for (const char* file : {"trajectory_fused.tum", "trajectory_mono.tum", "map_0.pgm"}) {
    EXPECT_EQ(common::readFile(dir.path() / "seed_1" / "lsm-robust" / file),
              common::readFile(dir.path() / "replay" / file))
        << file;
  }
}

TEST(ExperimentTest, AnErrorNamesTheSeed) {
  const test::TempDir dir;
  ExperimentOptions options{smallMission(), {3}, dir.path(), smallArena()};
  options.config.addOverride("arena_sim.world.width=-3");
  EXPECT_THAT(test::errorOf([&] { runExperiment(options); }),
              AllOf(HasSubstr("seed 3: "), HasSubstr("arena_sim.world.width")));
}

}  // namespace
}  // namespace rubble::tools
