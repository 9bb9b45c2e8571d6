// A whole process as systemd and a person at the terminal see it: arguments, exit status, HEALTH, signals,
// notification. All of it is runProcess(), which every process shares.
#include <gmock/gmock.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <rubble/health_t.hpp>

#include "bus_fixture.h"
#include "lcm_io/channels.h"
#include "lcm_io/log_file.h"
#include "support/child_process.h"
#include "support/temp_dir.h"

namespace rubble::lcm_io {
namespace {

using test::ChildProcess;
using testing::AllOf;
using testing::HasSubstr;

constexpr std::chrono::seconds kStopTime{3};

class ProcessTest : public LiveBusTest {
 protected:
  std::vector<rubble::health_t> hear(std::size_t count) {
    LcmBus bus(url_, "test");
    std::vector<rubble::health_t> heard;
    bus.subscribe<rubble::health_t>(channel::kHealth, [&](const rubble::health_t& m) { heard.push_back(m); });
    EXPECT_TRUE(dispatchUntil(bus, [&] { return heard.size() >= count; }));
    return heard;
  }
};

TEST_F(ProcessTest, PublishesHealthEverySecondAndStopsOnSigterm) {
  ChildProcess process({RUBBLE_FUSION, "--lcm-url", url_});
  const std::vector<rubble::health_t> heard = hear(3);
  ASSERT_GE(heard.size(), 3U);
  EXPECT_EQ(heard[0].process, "fusion");
  EXPECT_EQ(heard[0].pid, process.pid());
  EXPECT_NE(heard[0].state, "");
  EXPECT_NEAR(static_cast<double>(heard[2].utime - heard[0].utime), 2e6, 0.6e6);
  process.signal(SIGTERM);
  EXPECT_EQ(process.wait(kStopTime), 0);
  EXPECT_THAT(process.err(), HasSubstr("stopped"));
}

TEST_F(ProcessTest, StopsOnCtrlCWithALastHealth) {
  LcmBus bus(url_, "test");
  int heard = 0;
  bus.subscribe<rubble::health_t>(channel::kHealth, [&](const rubble::health_t&) { ++heard; });
  ChildProcess process({RUBBLE_FUSION, "--lcm-url", url_});
  ASSERT_TRUE(dispatchUntil(bus, [&] { return heard > 0; }));
  const int before = heard;
  process.signal(SIGINT);
  EXPECT_EQ(process.wait(kStopTime), 0);
  EXPECT_TRUE(dispatchUntil(bus, [&] { return heard > before; }));
}

TEST_F(ProcessTest, TwoOfAKindSayTheirNames) {
  ChildProcess first({RUBBLE_FUSION, "--lcm-url", url_});
  ChildProcess second({RUBBLE_FUSION, "--lcm-url", url_});
  LcmBus bus(url_, "test");
  std::vector<int> pids;
  bus.subscribe<rubble::health_t>(channel::kHealth,
                                  [&](const rubble::health_t& m) { pids.push_back(m.pid); });
  EXPECT_TRUE(dispatchUntil(bus, [&] {
    return std::count(pids.begin(), pids.end(), first.pid()) > 0 &&
           std::count(pids.begin(), pids.end(), second.pid()) > 0;
  }));
}

TEST(ProcessArguments, HelpIsAnAnswer) {
  ChildProcess process({RUBBLE_FUSION, "--help"});
  EXPECT_EQ(process.wait(), 0);
  EXPECT_THAT(process.out(), AllOf(HasSubstr("--lcm-url"), HasSubstr("--config"), HasSubstr("Example:")));
  EXPECT_EQ(process.err(), "");
}

TEST(ProcessArguments, AnUnknownOptionIsAMisuse) {
  ChildProcess process({RUBBLE_FUSION, "--confg", "x"});
  EXPECT_EQ(process.wait(), 2);
  EXPECT_THAT(process.err(), HasSubstr("--confg"));
}

TEST(ProcessArguments, BadConfigurationIsOneLineWithItsPlace) {
  const test::TempDir dir;
  const std::filesystem::path file = dir.write("robot.yaml", "# mounts\nfushion:\n  gain: 1\n");
  ChildProcess process({RUBBLE_FUSION, "--config", file.string()});
  EXPECT_EQ(process.wait(), 1);
  EXPECT_THAT(process.err(),
              HasSubstr(file.string() + ":2: unknown key `fushion`; did you mean `fusion`?\n"));
  EXPECT_EQ(std::count(process.err().begin(), process.err().end(), '\n'), 1) << process.err();
}

TEST(ProcessArguments, AMissingConfigurationIsOneLine) {
  ChildProcess process({RUBBLE_FUSION, "--config", "/nonexistent/robot.yaml"});
  EXPECT_EQ(process.wait(), 1);
  EXPECT_THAT(process.err(),
              HasSubstr("/nonexistent/robot.yaml: cannot be read (No such file or directory)\n"));
}

TEST(ProcessArguments, ABadUrlIsAnErrorThatNamesIt) {
  ChildProcess process({RUBBLE_FUSION, "--lcm-url", "carrier-pigeon://"});
  EXPECT_EQ(process.wait(), 1);
  EXPECT_THAT(process.err(), HasSubstr("--lcm-url carrier-pigeon://: LCM cannot open it"));
}

TEST(ProcessArguments, ALogIsPlayedToItsEnd) {
  const test::TempDir dir;
  const std::filesystem::path log = dir.path() / "a.lcm";
  LogWriter(log).write(1'700'000'000'000'000, "ANYTHING", Bytes{1});
  ChildProcess process({RUBBLE_FUSION, "--lcm-url", "file://" + log.string() + "?speed=0"});
  EXPECT_EQ(process.wait(), 0);
  EXPECT_THAT(process.err(), HasSubstr("stopped"));
}

TEST(ProcessArguments, TheConfigurationIsPrinted) {
  ChildProcess process({RUBBLE_FUSION, "--print-config"});
  EXPECT_EQ(process.wait(), 0);
  EXPECT_NE(process.out(), "");
}

/// systemd's end of the notification socket.
class NotifySocket {
 public:
  NotifySocket() : path_(dir_.path() / "notify"), fd_(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path_.string().copy(address.sun_path, sizeof(address.sun_path) - 1);
    EXPECT_EQ(::bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
  }
  ~NotifySocket() { ::close(fd_); }
  NotifySocket(const NotifySocket&) = delete;
  NotifySocket& operator=(const NotifySocket&) = delete;

  std::string variable() const { return "NOTIFY_SOCKET=" + path_.string(); }

  /// Reads until a notification holds the text.
  bool hears(const std::string& text) {
    const auto deadline = std::chrono::steady_clock::now() + test::kDeadline;
    while (std::chrono::steady_clock::now() < deadline) {
      pollfd ready{fd_, POLLIN, 0};
      char buffer[4096];
      if (::poll(&ready, 1, 1000) > 0) {
        const ssize_t n = ::recv(fd_, buffer, sizeof(buffer), 0);
        if (n > 0 && std::string(buffer, static_cast<std::size_t>(n)).find(text) != std::string::npos) {
          return true;
        }
      }
    }
    return false;
  }

 private:
  test::TempDir dir_;
  std::filesystem::path path_;
  int fd_;
};

TEST_F(ProcessTest, TellsSystemdReadyWatchdogAndStopping) {
  NotifySocket systemd;
  ChildProcess process({RUBBLE_FUSION, "--lcm-url", url_}, {systemd.variable()});
  EXPECT_TRUE(systemd.hears("READY=1"));
  EXPECT_TRUE(systemd.hears("WATCHDOG=1\nSTATUS="));
  EXPECT_TRUE(systemd.hears("WATCHDOG=1")) << "again and again";
  process.signal(SIGTERM);
  EXPECT_TRUE(systemd.hears("STOPPING=1"));
  EXPECT_EQ(process.wait(kStopTime), 0);
}

}  // namespace
}  // namespace rubble::lcm_io
