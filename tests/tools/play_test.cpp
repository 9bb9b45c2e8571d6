#include "play.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <rubble/odometry_t.hpp>
#include <string>
#include <vector>

#include "output_log.h"
#include "stop_signal.h"
#include "support/error_text.h"
#include "support/temp_dir.h"

namespace rubble::tools {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;
using ::testing::ElementsAre;

class PlayTest : public ::testing::Test {
 protected:
  PlayTest() : log_(dir_.path() / "a.lcm") {
    lcm_io::LogWriter writer(log_);
    writer.write(1'000'000, "HEALTH", {});
    writer.write(5'000'000, "SCAN", {});
    writer.write(5'100'000, "LIDAR_POSE", {});
    writer.write(5'200'000, "CAMERA", {});
    writer.write(5'300'000, "UNKNOWN", {});
    writer.write(6'000'000, "ODOMETRY", {});
    writer.close();
  }

  PlayResult play(double speed, std::size_t stop_after) {
    return playLog(log_, speed,
                   {[this](lcm_io::LogEvent& event) { channels_.push_back(event.channel); },
                    [this, stop_after](steady_clock::time_point deadline) {
                      deadlines_.push_back(deadline);
                      return channels_.size() == stop_after;
                    }});
  }

  test::TempDir dir_;
  std::filesystem::path log_;
  std::vector<std::string> channels_;
  std::vector<steady_clock::time_point> deadlines_;
};

TEST_F(PlayTest, OnlySourcesAtTheirPace) {
  const PlayResult result = play(2.0, 99);
  EXPECT_THAT(channels_, ElementsAre("SCAN", "CAMERA", "ODOMETRY"));
  EXPECT_EQ(result.played, 3);
  EXPECT_EQ(result.held_back, 3);
  EXPECT_FALSE(result.stopped);
  EXPECT_EQ(deadlines_.at(1) - deadlines_.at(0), milliseconds(100));
  EXPECT_EQ(deadlines_.at(2) - deadlines_.at(0), milliseconds(500));
}

TEST_F(PlayTest, SpeedZeroDoesNotWait) {
  play(0.0, 99);
  EXPECT_EQ(deadlines_.at(2), deadlines_.at(0));
}

TEST_F(PlayTest, StopsBetweenMessages) {
  const PlayResult result = play(1.0, 1);
  EXPECT_TRUE(result.stopped);
  EXPECT_EQ(result.played, 1);
}

TEST_F(PlayTest, ACutOffLogPlaysWhatIsWhole) {
  std::filesystem::resize_file(log_, std::filesystem::file_size(log_) - 3);
  EXPECT_EQ(play(0.0, 99).played, 2);
}

TEST(StopSignalTest, WaitsForTheDeadlineOrTheSignal) {
  StopSignal stop;
  const auto start = steady_clock::now();
  EXPECT_FALSE(stop.waitUntil(start + milliseconds(20)));
  EXPECT_GE(steady_clock::now(), start + milliseconds(20));
  EXPECT_FALSE(stop.waitUntil(start));
  raise(SIGINT);  // Blocked: it waits to be taken.
  EXPECT_TRUE(stop.waitUntil(start + std::chrono::hours(1)));
}

TEST(OutputLogTest, OrdersWithinItsWindow) {
  test::TempDir dir;
  const auto path = dir.path() / "a.lcm";
  const auto times = [&](common::Utime window, const std::vector<common::Utime>& written) {
    OutputLog log(path, window);
    for (const common::Utime utime : written) {
      rubble::odometry_t message{};
      message.utime = utime;
      log.write(utime, "ODOMETRY", message);
    }
    EXPECT_TRUE(!std::filesystem::exists(path));
    log.finish();
    std::vector<common::Utime> read;
    lcm_io::LogReader reader(path);
    while (const auto event = reader.next()) {
      read.push_back(event->utime);
    }
    std::filesystem::remove(path);
    return read;
  };
  EXPECT_THAT(times(OutputLog::kWholeFile, {5, 900, -3, 7}), ElementsAre(-3, 5, 7, 900));
  EXPECT_THAT(times(10, {100, 95, 105, 102}), ElementsAre(95, 100, 102, 105));
  EXPECT_THAT(times(10, {100, 200, 50}), ElementsAre(100, 50, 200));  // Too late to be in order, not lost.
}

}  // namespace
}  // namespace rubble::tools
