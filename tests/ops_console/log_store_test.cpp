#include "log_store.h"

#include <gtest/gtest.h>

#include <fstream>

#include "log_content.h"
#include "log_files.h"
#include "small_disk.h"
#include "support/error_text.h"
#include "support/temp_dir.h"

namespace rubble::ops_console {
namespace {

constexpr common::Utime kSecond = common::kMicrosecondsPerSecond;
constexpr common::Utime kStart = 1'795'369'501 * kSecond;
constexpr LogLimits kWide{1'000'000'000, 1'000'000'000, 3600 * kSecond};

TEST(LogStore, RotatesBySizeAtEventBoundaries) {
  const test::TempDir folder;
  LogLimits limits = kWide;
  limits.rotate_bytes = 10'000;
  LogStore store(folder.path() / "made" / "here", limits);
  for (std::uint32_t i = 0; i < 100; ++i) {
    store.write({numbered("TEST", i, 900, kStart + i)});
  }
  store.sync();
  const auto logs = listLogs(folder.path() / "made" / "here");
  EXPECT_EQ(logs.size(), 10U);
  for (const LogFile& log : logs) {
    EXPECT_LE(log.bytes, limits.rotate_bytes);
  }
  EXPECT_EQ(numbersOn("TEST", eventsIn(folder.path() / "made" / "here")), countFrom(0, 100));
}

TEST(LogStore, RotatesByTheTimeOfTheMessages) {
  const test::TempDir folder;
  LogLimits limits = kWide;
  limits.rotate_interval = 10 * kSecond;
  LogStore store(folder.path(), limits);
  for (std::uint32_t i = 0; i < 35; ++i) {
    store.write({numbered("TEST", i, 10, kStart + i * kSecond)});
  }
  store.write({numbered("TEST", 35, 10, kStart - 3600 * kSecond)});  // The clock was set back.
  store.sync();
  const auto logs = listLogs(folder.path());
  ASSERT_EQ(logs.size(), 5U);
  EXPECT_EQ(logs[0].path.filename(), logFileName(kStart - 3600 * kSecond, 0));
  EXPECT_EQ(logs[1].path.filename(), logFileName(kStart, 0));
  EXPECT_EQ(logs[4].path.filename(), logFileName(kStart + 30 * kSecond, 0));
}

TEST(LogStore, NeverOverwritesAnExistingLog) {
  const test::TempDir folder;
  for (std::uint32_t i = 0; i < 3; ++i) {
    LogStore store(folder.path(), kWide);
    store.write({numbered("TEST", i, 10, kStart)});
    store.sync();
  }
  EXPECT_EQ(listLogs(folder.path()).size(), 3U);
  EXPECT_EQ(numbersOn("TEST", eventsIn(folder.path())), countFrom(0, 3));
}

TEST(LogStore, DeletesTheOldestLogsAndNothingElse) {
  const test::TempDir folder;
  const auto foreign = folder.path() / "precious.lcm";
  std::ofstream(foreign) << std::string(100'000, 'x');
  const LogLimits limits{50'000, 10'000, 3600 * kSecond};
  LogStore store(folder.path(), limits);
  for (std::uint32_t i = 0; i < 300; ++i) {
    store.write({numbered("TEST", i, 900, kStart + i * kSecond)});
    store.sync();
    std::int64_t total = 0;
    for (const LogFile& log : listLogs(folder.path())) {
      total += log.bytes;
    }
    ASSERT_LE(total, limits.quota_bytes);
  }
  EXPECT_TRUE(std::filesystem::exists(foreign));
  std::filesystem::remove(foreign);
  const auto numbers = numbersOn("TEST", eventsIn(folder.path()));
  ASSERT_GT(numbers.size(), 40U);
  EXPECT_EQ(numbers, countFrom(300 - static_cast<std::uint32_t>(numbers.size()), numbers.size()));
}

TEST(LogStore, FullDiskTakesABatchWholeOrNotAtAll) {
  const SmallDisk disk;
  if (!disk.mounted()) {
    GTEST_SKIP() << "mounting a tmpfs is not permitted here";
  }
  const auto ballast = disk.path() / "ballast";
  std::ofstream(ballast) << std::string(6'000'000, 'x');
  LogStore store(disk.path(), kWide);
  std::uint32_t number = 0;
  const auto nextBatch = [&] {
    std::vector<lcm_io::RawMessage> batch;
    for (std::uint32_t i = 0; i < 10; ++i) {
      batch.push_back(numbered("TEST", number + i, 50'000, kStart + number + i));
    }
    return batch;
  };
  std::string error = "(no error)";
  for (; error == "(no error)" && number < 1000; number += error == "(no error)" ? 10 : 0) {
    error = test::errorOf([&] { store.write(nextBatch()); });
  }
  EXPECT_NE(error.find("disk full"), std::string::npos) << error;
  EXPECT_NE(error.find("quota_mb"), std::string::npos) << error;
  EXPECT_EQ(numbersOn("TEST", eventsIn(disk.path())), countFrom(0, number));
  const std::size_t files = listLogs(disk.path()).size();
  EXPECT_THROW(store.write(nextBatch()), common::Error);
  EXPECT_EQ(listLogs(disk.path()).size(), files) << "an attempt in vain leaves no file";

  std::filesystem::remove(ballast);
  store.write(nextBatch());
  store.sync();
  EXPECT_EQ(listLogs(disk.path()).size(), files + 1);
  EXPECT_EQ(numbersOn("TEST", eventsIn(disk.path())), countFrom(0, number + 10));
}

TEST(LogStore, FolderThatCannotBeIsNamed) {
  LogStore store("/proc/none", kWide);
  const std::string error = test::errorOf([&] { store.write({numbered("TEST", 0, 10, kStart)}); });
  EXPECT_NE(error.find("/proc/none"), std::string::npos) << error;
  EXPECT_NE(error.find("ops_console.log_dir"), std::string::npos) << error;
}

}  // namespace
}  // namespace rubble::ops_console
