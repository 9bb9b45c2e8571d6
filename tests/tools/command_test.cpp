#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <string>
#include <vector>

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

}  // namespace
}  // namespace rubble::tools
