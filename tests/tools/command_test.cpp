#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bot_core/planar_lidar_t.hpp>
#include <cmath>
#include <csignal>
#include <string>
#include <vector>

#include "lcm_io/channels.h"
#include "lcm_io/lcm_bus.h"
#include "lcm_io/log_file.h"
#include "support/child_process.h"
#include "support/lcm_url.h"
#include "support/temp_dir.h"

namespace rubble::tools {
namespace {

using test::ChildProcess;
using ::testing::AllOf;
using ::testing::HasSubstr;

struct Outcome {
  std::optional<int> status;
  std::string out;
  std::string err;
};

Outcome rubble(std::vector<std::string> arguments, const std::vector<std::string>& environment = {}) {
  arguments.insert(arguments.begin(), RUBBLE_PROGRAM);
  ChildProcess process(arguments, environment);
  const auto status = process.wait();
  return {status, process.out(), process.err()};
}

int lines(const std::string& text) { return static_cast<int>(std::count(text.begin(), text.end(), '\n')); }

TEST(CommandTest, EveryCommandHasHelpWithAnExample) {
  const std::vector<std::vector<std::string>> commands = {{},
                                                          {"import"},
                                                          {"import", "carmen"},
                                                          {"import", "tum"},
                                                          {"import", "euroc"},
                                                          {"import", "kitti"},
                                                          {"import", "rosbag"},
                                                          {"export"},
                                                          {"export", "tum"},
                                                          {"export", "carmen"},
                                                          {"replay"},
                                                          {"play"},
                                                          {"eval"},
                                                          {"eval", "ate"},
                                                          {"eval", "relations"},
                                                          {"eval", "map"},
                                                          {"eval", "marks"},
                                                          {"eval", "objects"},
                                                          {"arena"},
                                                          {"calibrate"},
                                                          {"calibrate", "camera"},
                                                          {"calibrate", "extrinsics"},
                                                          {"emulate"},
                                                          {"emulate", "lidar"},
                                                          {"emulate", "lidar", "a", "--pty", "--port", "1"},
                                                          {"emulate", "stabilizer"},
                                                          {"experiment"},
                                                          {"doctor"},
                                                          {"spy"},
                                                          {"train"}};
  for (std::vector<std::string> command : commands) {
    command.emplace_back("--help");
    const Outcome run = rubble(command);
    EXPECT_EQ(run.status, 0) << ::testing::PrintToString(command);
    EXPECT_THAT(run.out, AllOf(HasSubstr("Example"), HasSubstr("rubble ")))
        << ::testing::PrintToString(command);
  }
}

TEST(CommandTest, WrongUsageIsStatus2) {
  for (const std::vector<std::string>& command :
       std::vector<std::vector<std::string>>{{},
                                             {"fly"},
                                             {"import"},
                                             {"import", "carmen", "a.clf"},
                                             {"eval", "ate", "a", "b"},
                                             {"eval", "ate", "a", "b", "--align", "somehow"},
                                             {"arena"},
                                             {"arena", "--out", "a", "--samples", "b"},
                                             {"play"},
                                             {"play", "a.lcm", "--speed", "-1"}}) {
    const Outcome run = rubble(command);
    EXPECT_EQ(run.status, 2) << ::testing::PrintToString(command);
    EXPECT_NE(run.err, "");
  }
}

TEST(CommandTest, BadInputIsStatus1AndOneLine) {
  const test::TempDir dir;
  const std::string text = dir.write("text", "hello\nworld\n").string();
  const std::string out = (dir.path() / "out").string();
  for (const std::vector<std::string>& command :
       std::vector<std::vector<std::string>>{{"import", "carmen", text, "--out", out},
                                             {"import", "rosbag", text, "--out", out},
                                             {"import", "tum", text, "--out", out},
                                             {"export", "carmen", text, "--out", out},
                                             {"export", "tum", text, "--out", out},
                                             {"play", text},
                                             {"emulate", "lidar", text},
                                             {"emulate", "lidar", text, "--fault", "cut"},
                                             {"emulate", "stabilizer", "--interface", "nosuchcan0"},
                                             {"emulate", "stabilizer", "--fault", "fault@5"},
                                             {"emulate", "stabilizer", "--fault", "roll:cut@5"},
                                             {"eval", "ate", text, text, "--align", "sim3"},
                                             {"eval", "relations", text, text},
                                             {"eval", "map", text, text},
                                             {"eval", "marks", dir.path(), text},
                                             {"doctor", "--log-dir", dir.path() / "none"}}) {
    const Outcome run = rubble(command);
    EXPECT_EQ(run.status, 1) << ::testing::PrintToString(command);
    EXPECT_EQ(lines(run.err), 1) << run.err;
    EXPECT_THAT(run.err, HasSubstr("rubble: "));
  }
}

TEST(CommandTest, DoctorHearsWhatRunsAndWhatItLacks) {
  RUBBLE_NEEDS_MULTICAST();
  const std::string url = test::privateLcmUrl();
  const ChildProcess lidar(
      {RUBBLE_LIDAR, "--lcm-url", url, "--set", "lidar.connection=serial:///dev/no-lidar"});
  const Outcome run = rubble({"doctor", "--lcm-url", url});
  EXPECT_THAT(run.out, AllOf(HasSubstr("FIX  lidar: "), HasSubstr("/dev/no-lidar")));
  EXPECT_EQ(run.status, 1);
}

TEST(CommandTest, EvaluationsSpeakJson) {
  const test::TempDir dir;
  const std::string tum = dir.write("a.tum", "0 0 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n2 1 1 0 0 0 0 1\n").string();
  const std::string relations = dir.write("r.relations", "0 1 1 0 0 0 0 0\n1 7 0 0 0 0 0 0\n").string();
  EXPECT_THAT(rubble({"eval", "ate", tum, tum, "--align", "start", "--json"}).out,
              AllOf(HasSubstr("\"translation_rmse_m\": 0.0"), HasSubstr("\"tracked_share\": 1.0"),
                    HasSubstr("\"scale\": 1.0")));
  const Outcome run = rubble({"eval", "relations", tum, relations, "--json"});
  EXPECT_EQ(run.status, 0);
  EXPECT_THAT(run.out, AllOf(HasSubstr("\"matched\": 1"), HasSubstr("\"total\": 2")));
  EXPECT_THAT(run.err, HasSubstr("1 of 2 relations"));
}

TEST(CommandTest, SpySaysWhatIsMissing) {
  EXPECT_THAT(rubble({"spy"}, {"PATH=/nowhere"}).err, HasSubstr("apt-get install liblcm-java"));
}

TEST(CommandTest, PlayReachesTheBusAndStopsOnSigint) {
  RUBBLE_NEEDS_MULTICAST();
  const test::TempDir dir;
  const std::string log = (dir.path() / "a.lcm").string();
  {
    lcm_io::LogWriter writer(log);
    writer.write(0, "SCAN", std::vector<std::uint8_t>{1, 2, 3});
    writer.write(1, "HEALTH", std::vector<std::uint8_t>{4});
    writer.write(3'600'000'000, "SCAN", std::vector<std::uint8_t>{5});
    writer.close();
  }
  const std::string url = test::privateLcmUrl();
  lcm_io::LcmBus bus(url, "test");
  std::vector<lcm_io::RawMessage> received;
  bus.subscribeRaw("SCAN", [&](const lcm_io::RawMessage& message) { received.push_back(message); });
  ChildProcess play({RUBBLE_PROGRAM, "play", log, "--lcm-url", url});
  ASSERT_TRUE(
      test::waitUntil([&] { return bus.dispatch(std::chrono::milliseconds(10)) || !received.empty(); }));
  EXPECT_EQ(received.at(0).channel, "SCAN");
  EXPECT_THAT(received.at(0).data, ::testing::ElementsAre(1, 2, 3));
  play.signal(SIGINT);  // It waits for the message one hour later.
  EXPECT_EQ(play.wait(), 0);
  EXPECT_THAT(play.out(), HasSubstr("stopped after 1 messages"));
}

/// A log of `count` scans at 20 Hz, 181 beams of 1 m and i cm.
std::string scanLog(const test::TempDir& dir, int count) {
  const std::string log = (dir.path() / "scans.lcm").string();
  lcm_io::LogWriter writer(log);
  for (int i = 0; i < count; ++i) {
    bot_core::planar_lidar_t scan{};
    scan.utime = 1'700'000'000'000'000 + 50'000 * i;
    scan.nranges = 181;
    scan.ranges.assign(181, 1.0F + 0.01F * static_cast<float>(i));
    scan.rad0 = static_cast<float>(-M_PI / 2);
    scan.radstep = static_cast<float>(M_PI / 180);
    writer.writeMessage(scan.utime, lcm_io::channel::kScan, scan);
  }
  writer.close();
  return log;
}

TEST(CommandTest, EmulatedLidarEndsWithItsLog) {
  const test::TempDir dir;
  const Outcome run = rubble({"emulate", "lidar", scanLog(dir, 5), "--port", "0"});
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_THAT(run.out, AllOf(HasSubstr("LiDAR at tcp://127.0.0.1:"), HasSubstr("181 beams, 20.0 Hz"),
                             HasSubstr("sent 0 scans")));
}

TEST(CommandTest, EmulatedLidarFeedsTheDriver) {
  RUBBLE_NEEDS_MULTICAST();
  const test::TempDir dir;
  ChildProcess emulator(
      {RUBBLE_PROGRAM, "emulate", "lidar", scanLog(dir, 5), "--pty", "--loop", "--fault", "checksum@0"});
  const std::string before = "LiDAR at ";
  ASSERT_TRUE(test::waitUntil([&] {
    emulator.wait(std::chrono::milliseconds(10));
    return emulator.out().find('\n') != std::string::npos;
  })) << emulator.err();
  const std::string address = emulator.out().substr(before.size(), emulator.out().find(": ") - before.size());
  const std::string url = test::privateLcmUrl();
  lcm_io::LcmBus bus(url, "test");
  std::vector<bot_core::planar_lidar_t> scans;
  bus.subscribe<bot_core::planar_lidar_t>(lcm_io::channel::kScan,
                                          [&](const auto& scan) { scans.push_back(scan); });
  ChildProcess driver({RUBBLE_LIDAR, "--lcm-url", url, "--set", "lidar.connection=" + address});
  ASSERT_TRUE(
      test::waitUntil([&] { return bus.dispatch(std::chrono::milliseconds(10)) && scans.size() >= 10; }));
  EXPECT_EQ(scans[0].nranges, 181);
  EXPECT_NEAR(scans[0].rad0, -M_PI / 2, 1e-6);
  for (const auto& scan : scans) {
    const float centimetres = 100.0F * (scan.ranges[90] - 1.0F);
    EXPECT_NEAR(centimetres, std::round(centimetres), 0.01);
    EXPECT_LT(centimetres, 4.5F);
  }
  driver.signal(SIGTERM);
  EXPECT_EQ(driver.wait(), 0) << driver.err();
  emulator.signal(SIGINT);
  EXPECT_EQ(emulator.wait(), 0) << emulator.err();
}

}  // namespace
}  // namespace rubble::tools
