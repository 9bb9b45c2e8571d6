#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <fstream>
#include <optional>
#include <rubble/health_t.hpp>

#include "lcm_io/channels.h"
#include "lcm_io/lcm_bus.h"
#include "log_content.h"
#include "small_disk.h"
#include "support/child_process.h"
#include "support/lcm_url.h"
#include "support/shell.h"
#include "support/temp_dir.h"

namespace rubble::ops_console {
namespace {

constexpr common::Utime kSecond = common::kMicrosecondsPerSecond;
constexpr std::size_t kMessageBytes = 2000;

/// The real rubble-console on a port of its own, and a publisher beside it.
class ConsoleProcessTest : public testing::Test {
 protected:
  void SetUp() override {
    RUBBLE_NEEDS_MULTICAST();
    url_ = test::privateLcmUrl();
    bus_.emplace(url_, "test");
    bus_->subscribe<rubble::health_t>(lcm_io::channel::kHealth,
                                      [this](const rubble::health_t& h) { health_ = h; });
  }

  void start(const std::filesystem::path& log_dir) {
    console_.emplace(std::vector<std::string>{RUBBLE_CONSOLE, "--lcm-url", url_, "--set",
                                              "ops_console.log_dir=" + log_dir.string()});
    ASSERT_TRUE(waitFor([&] { return health_.pid == console_->pid(); }));
  }

  std::optional<int> stop(int signal) {
    console_->signal(signal);
    return console_->wait();
  }

  void publish(std::size_t bytes = kMessageBytes) {
    bus_->publishRaw("TEST", numbered("TEST", sent_++, bytes, 0).data);
  }

  /// Publishes one message per millisecond or so, as `each` does, until the condition holds.
  template <typename Condition>
  bool publishUntil(Condition condition, std::size_t bytes = kMessageBytes) {
    const common::Utime deadline = bus_->now() + 15 * kSecond;
    while (!condition() && bus_->now() < deadline) {
      publish(bytes);
      bus_->dispatch(std::chrono::milliseconds(1));
    }
    return condition();
  }

  template <typename Condition>
  bool waitFor(Condition condition) {
    const common::Utime deadline = bus_->now() + 15 * kSecond;
    while (!condition() && bus_->now() < deadline) {
      bus_->dispatch(std::chrono::milliseconds(20));
    }
    return condition();
  }

  std::int64_t counter(const std::string& name) const {
    for (const rubble::counter_t& c : health_.counters) {
      if (c.name == name) {
        return c.count;
      }
    }
    return 0;
  }

  std::string url_;
  std::optional<lcm_io::LcmBus> bus_;
  std::optional<test::ChildProcess> console_;
  rubble::health_t health_{};
  std::uint32_t sent_ = 0;
};

/// Events that the real lcm-logplayer plays from the log.
std::size_t playedByLogplayer(const std::filesystem::path& log) {
  const test::ShellResult played = test::shell("lcm-logplayer -v -s 1000 -l memq:// " + log.string());
  EXPECT_EQ(played.status, 0) << played.output;
  std::size_t events = 0;
  for (std::size_t at = 0; (at = played.output.find(" Channel ", at)) != std::string::npos; ++at) {
    ++events;
  }
  return events;
}

TEST_F(ConsoleProcessTest, KilledItLeavesALogUpToTheLastSecond) {
  const test::TempDir folder;
  start(folder.path());
  ASSERT_TRUE(publishUntil([&] { return counter("logged") > 1500; }));
  EXPECT_EQ(stop(SIGKILL), 128 + SIGKILL);
  const common::Utime killed_utime = bus_->now();

  const auto events = eventsIn(folder.path(), true);
  ASSERT_FALSE(events.empty());
  const auto numbers = numbersOn("TEST", events);
  EXPECT_EQ(numbers, countFrom(0, numbers.size()));
  EXPECT_GT(events.back().utime, killed_utime - kSecond);
  const auto files = filesIn(folder.path());
  ASSERT_EQ(files.size(), 1U);
  EXPECT_EQ(playedByLogplayer(files.front()), events.size());
}

TEST_F(ConsoleProcessTest, TerminatedItLogsAllThatWasPublished) {
  const test::TempDir folder;
  start(folder.path());
  for (int i = 0; i < 1000; ++i) {
    publish();
  }
  EXPECT_EQ(stop(SIGTERM), 0);
  EXPECT_EQ(numbersOn("TEST", eventsIn(folder.path())), countFrom(0, 1000));
}

TEST_F(ConsoleProcessTest, FullDiskIsReportedAndSurvived) {
  const SmallDisk disk;
  if (!disk.mounted()) {
    GTEST_SKIP() << "mounting a tmpfs is not permitted here";
  }
  const auto ballast = disk.path() / "ballast";
  std::ofstream(ballast) << std::string(7'000'000, 'x');
  start(disk.path());
  ASSERT_TRUE(publishUntil([&] { return health_.level == rubble::health_t::LEVEL_ERROR; }));
  EXPECT_NE(health_.detail.find("disk full"), std::string::npos) << health_.detail;

  std::filesystem::remove(ballast);
  const std::int64_t before = counter("logged");
  ASSERT_TRUE(
      waitFor([&] { return health_.level != rubble::health_t::LEVEL_ERROR && counter("logged") > before; }));
  EXPECT_EQ(counter("log_dropped"), 0);
  EXPECT_EQ(stop(SIGTERM), 0);
  EXPECT_EQ(numbersOn("TEST", eventsIn(disk.path())), countFrom(0, sent_));
  EXPECT_GE(filesIn(disk.path()).size(), 2U);
}

TEST(ConsoleProcess, WrongConfigurationEndsItWithOneLine) {
  test::ChildProcess console({RUBBLE_CONSOLE, "--set", "ops_console.rotate_mb=15000"});
  EXPECT_EQ(console.wait(), 1);
  EXPECT_NE(console.err().find("ops_console.quota_mb"), std::string::npos) << console.err();
  EXPECT_EQ(std::count(console.err().begin(), console.err().end(), '\n'), 1);
}

}  // namespace
}  // namespace rubble::ops_console
