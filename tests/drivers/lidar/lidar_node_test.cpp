// The whole driver against the emulated sensor, over TCP and over a pty.
#include "lidar_node.h"

#include <gmock/gmock.h>

#include <cmath>

#include "lcm_io/channels.h"
#include "lcm_io/lcm_bus.h"
#include "lidar_emulator/lidar_emulator.h"
#include "support/allocation_watch.h"
#include "support/lcm_url.h"
#include "support/temp_dir.h"
#include "support/wait_until.h"

namespace rubble::lidar {
namespace {

using Level = lcm_io::NodeStatus::Level;
using std::chrono::milliseconds;
using testing::HasSubstr;
using testing::StartsWith;

constexpr double kRate = 100.0;
constexpr int kBeams = 1081;
// Long enough for a test to see the failure before it is mended.
constexpr milliseconds kPause{500};

/// Scan i's ranges are 1 m + i mm (up to 20 m), so that a message tells which one it is.
float rangeOfScan(int i) { return 1.0F + 0.001F * static_cast<float>(i % 19'000); }

ScanSource endlessScans() {
  return [i = 0](EmulatedScan& scan) mutable {
    test::leaveThreadOut();
    scan.since_first = std::chrono::microseconds(std::llround(1e6 * i / kRate));
    scan.ranges.assign(kBeams, rangeOfScan(i));
    scan.intensities.assign(kBeams, 100.0F);
    ++i;
    return true;
  };
}

class LidarNodeTest : public testing::TestWithParam<bool> {
 protected:
  LidarNodeTest() : bus_("memq://", "lidar") {
    bus_.subscribe<bot_core::planar_lidar_t>(lcm_io::channel::kScan,
                                             [this](const auto& scan) { scans_.push_back(scan); });
  }

  void startEmulator(int port = 0) {
    emulator_.reset();
    LidarEmulator::Options options{.pty = GetParam(), .port = port};
    if (options.pty) {
      options.pty_link = dir_.path() / "lidar";
    }
    emulator_ = std::make_unique<LidarEmulator>(options, EmulatedModel{.beams = kBeams, .rate = kRate},
                                                endlessScans());
  }

  void startNode(const ScanWish& wish = {.first_angle = -3.2, .last_angle = 3.2}) {
    node_ =
        std::make_unique<LidarNode>(bus_, LidarReader::Options{.address = parseAddress(emulator_->address()),
                                                               .wish = wish,
                                                               .silence = milliseconds(1000),
                                                               .first_pause = kPause,
                                                               .longest_pause = kPause});
  }

  template <typename Condition>
  bool runUntil(const Condition& condition) {
    const auto deadline = std::chrono::steady_clock::now() + test::kDeadline;
    while (!condition()) {
      if (std::chrono::steady_clock::now() > deadline) {
        return false;
      }
      bus_.dispatch(milliseconds(20));
      node_->advance(bus_.now());
    }
    return true;
  }

  bool moreScans(std::size_t count) {
    const std::size_t wanted = scans_.size() + count;
    return runUntil([&] { return scans_.size() >= wanted; });
  }

  bool failsWith(const std::string& text) {
    return runUntil([&] { return node_->status().detail.find(text) != std::string::npos; });
  }

  std::int64_t counter(const std::string& name) const { return node_->status().counters.at(name); }

  const test::TempDir dir_;
  std::unique_ptr<LidarEmulator> emulator_;
  lcm_io::LcmBus bus_;
  std::unique_ptr<LidarNode> node_;
  std::vector<bot_core::planar_lidar_t> scans_;
};

INSTANTIATE_TEST_SUITE_P(Lines, LidarNodeTest, testing::Bool(),
                         [](const auto& line) { return line.param ? "Pty" : "Tcp"; });

TEST_P(LidarNodeTest, ScansArriveWithTheirAnglesAndTimes) {
  startEmulator();
  startNode();
  EXPECT_EQ(node_->status().level, Level::kDegraded) << "green only while scans flow";
  ASSERT_TRUE(moreScans(50));
  const bot_core::planar_lidar_t& first = scans_.front();
  EXPECT_EQ(first.nranges, kBeams);
  EXPECT_EQ(first.nintensities, 0);
  EXPECT_NEAR(first.rad0, -0.75 * M_PI, 1e-6);
  EXPECT_NEAR(first.radstep, M_PI / 720, 1e-9);
  const auto numberOf = [](const bot_core::planar_lidar_t& scan) {
    return std::lround(1e3F * (scan.ranges[0] - 1.0F));
  };
  for (std::size_t i = 1; i < scans_.size(); ++i) {
    EXPECT_GT(scans_[i].utime, scans_[i - 1].utime);
    // The scans' own pace, not that of their arrival.
    EXPECT_NEAR(static_cast<double>(scans_[i].utime - first.utime),
                1e6 / kRate * static_cast<double>(numberOf(scans_[i]) - numberOf(first)), 2500.0);
    EXPECT_LT(scans_[i].utime, bus_.now());
  }
  // Where the machine is so slow that scans were dropped, green returns after 10 s.
  ASSERT_TRUE(runUntil([&] { return node_->status().level == Level::kOk; })) << node_->status().detail;
  EXPECT_EQ(node_->status().state, "scanning");
  EXPECT_EQ(node_->status().detail, "");
}

TEST_P(LidarNodeTest, IntensitiesOnRequest) {
  startEmulator();
  startNode({.first_angle = -1.0, .last_angle = 1.0, .intensities = true});
  ASSERT_TRUE(moreScans(3));
  EXPECT_EQ(scans_[0].nintensities, scans_[0].nranges);
  EXPECT_EQ(scans_[0].intensities[5], 100.0F);
  EXPECT_NEAR(scans_[0].rad0, -1.0, M_PI / 720);
}

TEST_P(LidarNodeTest, ACutInTheMiddleOfAScanIsReportedAndMended) {
  startEmulator();
  startNode();
  ASSERT_TRUE(moreScans(5));
  emulator_->inject(Fault::kCut);
  ASSERT_TRUE(failsWith(GetParam() ? "was unplugged (" : "closed the connection ("));
  const lcm_io::NodeStatus status = node_->status();
  EXPECT_THAT(status.detail, StartsWith("LiDAR " + emulator_->address()));
  EXPECT_EQ(status.level, Level::kError);
  EXPECT_EQ(status.state, "failed");
  ASSERT_TRUE(moreScans(5));
  EXPECT_EQ(node_->status().state, "scanning");
  EXPECT_GE(counter("failures"), 1);
}

TEST_P(LidarNodeTest, AFrozenSensorIsNoticedAndAskedAnew) {
  startEmulator();
  startNode();
  ASSERT_TRUE(moreScans(5));
  emulator_->inject(Fault::kFreeze);
  ASSERT_TRUE(failsWith("sends no scan for 1.0 s: it hangs or is cut off"));
  EXPECT_EQ(node_->status().level, Level::kError);
  ASSERT_TRUE(moreScans(5));
  EXPECT_EQ(node_->status().state, "scanning");
}

TEST_P(LidarNodeTest, AMalfunctionIsReportedAndTheSensorReset) {
  startEmulator();
  startNode();
  ASSERT_TRUE(moreScans(5));
  emulator_->inject(Fault::kMalfunction);
  ASSERT_TRUE(failsWith("answers MD with status 0L (malfunction); it is reset and tried again"));
  ASSERT_TRUE(moreScans(5));
  EXPECT_GE(counter("failures"), 1);
}

TEST_P(LidarNodeTest, DamageIsCountedAndScansGoOn) {
  startEmulator();
  startNode();
  ASSERT_TRUE(moreScans(5));
  for (const Fault fault : {Fault::kChecksum, Fault::kEcho, Fault::kGarbage}) {
    emulator_->inject(fault);
  }
  ASSERT_TRUE(runUntil([&] {
    return counter("scans_damaged") == 1 && counter("unexpected_answers") == 1 &&
           counter("garbage_bytes") > 0;
  }));
  ASSERT_TRUE(moreScans(3));
  const lcm_io::NodeStatus status = node_->status();
  EXPECT_EQ(status.level, Level::kDegraded);
  EXPECT_EQ(status.state, "scanning");
  EXPECT_THAT(status.detail, HasSubstr("check the cable"));
}

TEST_P(LidarNodeTest, AWrapIsNothingAndAJumpIsReported) {
  startEmulator();
  startNode();
  ASSERT_TRUE(moreScans(5));
  emulator_->inject(Fault::kClockWrap);  // Setting the clock is a jump; the wrap half a second later is none.
  ASSERT_TRUE(moreScans(100));
  EXPECT_EQ(counter("clock_jumps"), 1);
  emulator_->inject(Fault::kClockReset);
  ASSERT_TRUE(runUntil([&] { return counter("clock_jumps") == 2; }));
  EXPECT_THAT(node_->status().detail, HasSubstr("jumped"));
  ASSERT_TRUE(moreScans(5));
  for (std::size_t i = 1; i < scans_.size(); ++i) {
    EXPECT_GT(scans_[i].utime, scans_[i - 1].utime);
  }
}

using LidarNodeTcp = LidarNodeTest;
INSTANTIATE_TEST_SUITE_P(Lines, LidarNodeTcp, testing::Values(false), [](const auto&) { return "Tcp"; });

TEST_P(LidarNodeTcp, AnAbsentSensorIsNamedAndFoundWhenItComes) {
  startEmulator();
  const std::string address = emulator_->address();
  startNode();
  ASSERT_TRUE(moreScans(1));
  emulator_.reset();
  ASSERT_TRUE(failsWith("LiDAR " + address +
                        " cannot connect (Connection refused); is the LiDAR on and in this network, and "
                        "lidar.connection its address?"));
  startEmulator(std::stoi(address.substr(address.rfind(':') + 1)));
  EXPECT_TRUE(moreScans(5));
}

using LidarNodePty = LidarNodeTest;
INSTANTIATE_TEST_SUITE_P(Lines, LidarNodePty, testing::Values(true), [](const auto&) { return "Pty"; });

TEST_P(LidarNodePty, AnUnpluggedPortIsNamed) {
  startEmulator();
  startNode();
  ASSERT_TRUE(moreScans(1));
  emulator_.reset();
  EXPECT_TRUE(
      failsWith("cannot be opened (No such file or directory); is the LiDAR plugged in, and "
                "lidar.connection its port?"));
}

TEST_P(LidarNodeTcp, SteadyStateAllocatesNothing) {
  RUBBLE_NEEDS_MULTICAST();
  // As in the process: the bus hears its own messages, and nobody here wants them.
  lcm_io::LcmBus bus(test::privateLcmUrl(), "lidar");
  startEmulator();
  LidarNode node(bus, {.address = parseAddress(emulator_->address()),
                       .wish = {.first_angle = -3.2, .last_angle = 3.2, .intensities = true},
                       .silence = milliseconds(5000),
                       .first_pause = kPause,
                       .longest_pause = kPause});
  const auto publishUntil = [&](std::int64_t count) {
    const auto deadline = std::chrono::steady_clock::now() + test::kDeadline;
    const auto published = [&] {
      const auto found = bus.published().find(lcm_io::channel::kScan);
      return found == bus.published().end() ? 0 : found->second.count;
    };
    while (published() < count && std::chrono::steady_clock::now() < deadline) {
      bus.dispatch(milliseconds(20));
      node.advance(bus.now());
    }
    return published() >= count;
  };
  ASSERT_TRUE(publishUntil(100));  // All that goes round has grown.
  // Where this machine stalls a scan is lost, and saying so takes a string.
  std::int64_t allocations = 1;
  for (int i = 1; i <= 5 && allocations != 0; ++i) {
    test::watchAllocations();
    ASSERT_TRUE(publishUntil(100 + 200 * i));
    allocations = test::allocationCount();
  }
  EXPECT_EQ(allocations, 0);
}

}  // namespace
}  // namespace rubble::lidar
