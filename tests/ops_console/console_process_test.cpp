#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <fstream>
#include <rubble/health_t.hpp>

#include "lcm_io/channels.h"
#include "lcm_io/lcm_bus.h"
#include "log_content.h"
#include "temporary_folder.h"

namespace rubble::ops_console {
namespace {

constexpr common::Utime kSecond = common::kMicrosecondsPerSecond;
constexpr std::size_t kMessageBytes = 2000;

/// The real rubble-console on a port of its own, and a publisher beside it.
class ConsoleProcessTest : public testing::Test {
 protected:
  ConsoleProcessTest()
      : url_("udpm://239.255.76.67:" + std::to_string(20'000 + ::getpid() % 20'000) +
             "?ttl=0&recv_buf_size=4194304"),
        bus_(url_, "test") {
    bus_.subscribe<rubble::health_t>(lcm_io::channel::kHealth,
                                     [this](const rubble::health_t& h) { health_ = h; });
  }
  ~ConsoleProcessTest() override { stop(SIGKILL); }

  void start(const std::filesystem::path& log_dir) {
    const std::string set = "ops_console.log_dir=" + log_dir.string();
    const std::array<const char*, 6> argv{RUBBLE_CONSOLE, "--lcm-url", url_.c_str(),
                                          "--set",        set.c_str(), nullptr};
    ASSERT_EQ(
        ::posix_spawn(&pid_, RUBBLE_CONSOLE, nullptr, nullptr, const_cast<char**>(argv.data()), environ), 0);
    ASSERT_TRUE(waitFor([&] { return health_.pid == pid_; }));
  }

  /// Exit status of the console, -1 when a signal ended it.
  int stop(int signal) {
    if (pid_ == 0) {
      return -1;
    }
    ::kill(std::exchange(pid_, 0), signal);
    int status = 0;
    ::wait(&status);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

  void publish(std::size_t bytes = kMessageBytes) {
    bus_.publishRaw("TEST", numbered("TEST", sent_++, bytes, 0).data);
  }

  /// Publishes one message per millisecond or so, as `each` does, until the condition holds.
  template <typename Condition>
  bool publishUntil(Condition condition, std::size_t bytes = kMessageBytes) {
    const common::Utime deadline = bus_.now() + 15 * kSecond;
    while (!condition() && bus_.now() < deadline) {
      publish(bytes);
      bus_.dispatch(std::chrono::milliseconds(1));
    }
    return condition();
  }

  template <typename Condition>
  bool waitFor(Condition condition) {
    const common::Utime deadline = bus_.now() + 15 * kSecond;
    while (!condition() && bus_.now() < deadline) {
      bus_.dispatch(std::chrono::milliseconds(20));
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

  const std::string url_;
  lcm_io::LcmBus bus_;
  rubble::health_t health_{};
  ::pid_t pid_ = 0;
  std::uint32_t sent_ = 0;
};

/// Events that the real lcm-logplayer plays from the log.
std::size_t playedByLogplayer(const std::filesystem::path& log) {
  const std::string command = "lcm-logplayer -v -s 1000 -l memq:// " + log.string() + " 2>&1";
  std::FILE* pipe = ::popen(command.c_str(), "r");
  std::size_t events = 0;
  std::array<char, 512> line{};
  while (std::fgets(line.data(), static_cast<int>(line.size()), pipe) != nullptr) {
    events += std::string_view(line.data()).find(" Channel ") != std::string_view::npos ? 1 : 0;
  }
  EXPECT_EQ(::pclose(pipe), 0);
  return events;
}

TEST_F(ConsoleProcessTest, KilledItLeavesALogUpToTheLastSecond) {
  const TemporaryFolder folder;
  start(folder.path());
  ASSERT_TRUE(publishUntil([&] { return counter("logged") > 1500; }));
  stop(SIGKILL);
  const common::Utime killed_utime = bus_.now();

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
  const TemporaryFolder folder;
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

TEST_F(ConsoleProcessTest, WrongConfigurationEndsItWithOneLine) {
  EXPECT_EQ(
      std::system((std::string(RUBBLE_CONSOLE) + " --set ops_console.rotate_mb=15000 2>/dev/null").c_str()),
      1 << 8);
}

}  // namespace
}  // namespace rubble::ops_console
