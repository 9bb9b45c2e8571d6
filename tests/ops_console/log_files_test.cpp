#include "log_files.h"

#include <gtest/gtest.h>

#include <fstream>
#include <random>

#include "support/temp_dir.h"

namespace rubble::ops_console {
namespace {

constexpr common::Utime kSecond = common::kMicrosecondsPerSecond;
constexpr common::Utime kSomeTime = 1'795'369'501 * kSecond;  // 2026-11-22 17:45:01 UTC

TEST(LogFiles, AreNamedAfterTheUtcOfTheirFirstEvent) {
  EXPECT_EQ(logFileName(kSomeTime, 0), "rubble-20261122-174501-00.lcm");
  EXPECT_EQ(logFileName(kSomeTime + kSecond - 1, 7), "rubble-20261122-174501-07.lcm");
  EXPECT_EQ(logFileName(0, 0), "rubble-19700101-000000-00.lcm");
}

TEST(LogFiles, NamesSortByTime) {
  std::mt19937_64 random(1);
  std::uniform_int_distribution<common::Utime> times(0, 4 * kSomeTime);
  for (int i = 0; i < 1000; ++i) {
    const common::Utime a = times(random);
    const common::Utime b = times(random);
    EXPECT_TRUE(isLogFileName(logFileName(a, 0)));
    EXPECT_EQ(a / kSecond < b / kSecond, logFileName(a, 0) < logFileName(b, 0));
  }
}

TEST(LogFiles, OthersAreNotTaken) {
  for (const char* name : {"rubble-20261122-174501-00.lcm.bak", "mission.lcm", "rubble-20261122-174501-0.lcm",
                           "xrubble-20261122-174501-00.lcm", "rubble-2026112a-174501-00.lcm", ""}) {
    EXPECT_FALSE(isLogFileName(name)) << name;
  }
}

TEST(LogFiles, CollisionsGetTheNextFreeName) {
  const test::TempDir folder;
  for (int i = 0; i < 102; ++i) {
    const auto path = freeLogPath(folder.path(), kSomeTime);
    ASSERT_FALSE(std::filesystem::exists(path));
    if (i == 100) {
      EXPECT_EQ(path.filename(), logFileName(kSomeTime + kSecond, 0));
    }
    std::ofstream(path) << "x";
  }
  EXPECT_EQ(listLogs(folder.path()).size(), 102U);
}

TEST(LogFiles, QuotaTakesTheFewestOldestAndNeverTheCurrent) {
  std::mt19937 random(2);
  for (int round = 0; round < 500; ++round) {
    std::vector<LogFile> logs;
    std::int64_t total = 0;
    for (int i = 0; i < 8; ++i) {
      logs.push_back({logFileName(kSomeTime, i), static_cast<std::int64_t>(random() % 100)});
      total += logs.back().bytes;
    }
    const std::size_t current = random() % logs.size();
    const auto quota = static_cast<std::int64_t>(random() % 500);
    const auto excess = logsOverQuota(logs, quota, logs[current].path);

    // Oracle: drop one by one from the oldest, stop as soon as the rest fits.
    std::vector<std::filesystem::path> expected;
    for (std::size_t i = 0; i < logs.size() && total > quota; ++i) {
      if (i != current) {
        expected.push_back(logs[i].path);
        total -= logs[i].bytes;
      }
    }
    EXPECT_EQ(excess, expected);
  }
}

}  // namespace
}  // namespace rubble::ops_console
