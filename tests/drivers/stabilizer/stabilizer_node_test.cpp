// The whole driver against the emulated drives, over a CAN bus in memory.
#include "stabilizer_node.h"

#include <gmock/gmock.h>
#include <linux/can/error.h>

#include <cmath>
#include <rubble/stabilizer_command_t.hpp>
#include <rubble/stabilizer_t.hpp>

#include "device/socket_can.h"
#include "lcm_io/channels.h"
#include "lcm_io/lcm_bus.h"
#include "stabilizer_config.h"
#include "stabilizer_emulator/memory_can.h"
#include "stabilizer_emulator/stabilizer_emulator.h"
#include "support/allocation_watch.h"
#include "support/error_text.h"
#include "support/lcm_url.h"
#include "support/wait_until.h"

namespace rubble::stabilizer {
namespace {

using Level = lcm_io::NodeStatus::Level;
using std::chrono::milliseconds;
using testing::AnyOf;
using testing::HasSubstr;

StabilizerDriver::Options quickOptions() {
  StabilizerConfig config;
  // Machines under load and sanitizers stop for that long.
  config.heartbeat_timeout = 2.0;
  config.following_error = 3.0;
  return driverOptions(config);
}

class StabilizerNodeTest : public testing::Test {
 protected:
  StabilizerNodeTest() : bus_("memq://", "stabilizer") {
    bus_.subscribe<rubble::stabilizer_t>(lcm_io::channel::kStabilizer,
                                         [this](const auto& reading) { readings_.push_back(reading); });
    startEmulator();
    node_ = std::make_unique<StabilizerNode>(bus_, quickOptions(), "can0", [this] { return can_.open(); });
  }

  void startEmulator() {
    emulator_.reset();
    emulator_ = std::make_unique<StabilizerEmulator>(EmulatedModel{}, can_.open());
  }

  void command(double roll, double pitch, common::Utime valid = 300'000) {
    rubble::stabilizer_command_t command{};
    command.utime = bus_.now();
    command.valid_until_utime = command.utime + valid;
    command.roll = roll;
    command.pitch = pitch;
    bus_.publish(lcm_io::channel::kStabilizerCommand, command);
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
  bool reaches(const std::string& state) {
    return runUntil([&] { return node_->status().state == state; });
  }
  bool says(const std::string& text) {
    return runUntil([&] { return node_->status().detail.find(text) != std::string::npos; });
  }
  bool moreReadings(std::size_t count) {
    const std::size_t wanted = readings_.size() + count;
    return runUntil([&] { return readings_.size() >= wanted; });
  }

  MemoryCan can_;
  std::unique_ptr<StabilizerEmulator> emulator_;
  lcm_io::LcmBus bus_;
  std::unique_ptr<StabilizerNode> node_;
  std::vector<rubble::stabilizer_t> readings_;
};

TEST_F(StabilizerNodeTest, StartsAndHoldsAndIsGreenOnlyWhileItFollows) {
  EXPECT_EQ(node_->status().level, Level::kDegraded);
  ASSERT_TRUE(reaches("holding"));
  EXPECT_EQ(node_->status().level, Level::kDegraded);
  EXPECT_THAT(node_->status().detail, HasSubstr("no STABILIZER_COMMAND is valid"));
  ASSERT_TRUE(moreReadings(20));
  EXPECT_EQ(readings_.back().command_utime, 0);
  for (std::size_t i = 1; i < readings_.size(); ++i) {
    EXPECT_GT(readings_[i].utime, readings_[i - 1].utime);
  }
  ASSERT_TRUE(runUntil([&] {
    command(0.0, 0.0);
    return node_->status().level == Level::kOk;
  })) << node_->status().detail;
  EXPECT_EQ(node_->status().state, "following");
  EXPECT_EQ(node_->status().detail, "");
  ASSERT_TRUE(reaches("holding")) << "the command expires";
}

TEST_F(StabilizerNodeTest, FollowsASineAndMeasuresIt) {
  ASSERT_TRUE(reaches("holding"));
  const common::Utime begin = bus_.now();
  constexpr double kTurn = 2.0 * M_PI * 0.5;
  const auto angle = [&](common::Utime t) {
    return 0.2 * std::sin(kTurn * common::secondsFromUtime(t - begin));
  };
  common::Utime last_command = 0;
  double worst = 0.0;
  std::size_t seen = readings_.size();
  std::size_t compared = 0;
  common::Utime last_seen = 0;
  ASSERT_TRUE(runUntil([&] {
    const common::Utime now = bus_.now();
    if (now - last_command > 9'000) {
      last_command = now;
      rubble::stabilizer_command_t command{};
      command.utime = now;
      command.valid_until_utime = now + 500'000;
      command.roll = angle(now);
      command.pitch = -command.roll;
      command.roll_rate = 0.2 * kTurn * std::cos(kTurn * common::secondsFromUtime(now - begin));
      command.pitch_rate = -command.roll_rate;
      bus_.publish(lcm_io::channel::kStabilizerCommand, command);
    }
    for (; seen < readings_.size(); ++seen) {
      const auto& r = readings_[seen];
      // Where this machine kept the driver waiting nothing is to be compared.
      const bool steady =
          r.utime - last_seen < 15'000 && r.command_utime != 0 && r.utime - r.command_utime < 50'000;
      last_seen = r.utime;
      if (steady && r.utime > begin + 500'000) {
        ++compared;
        worst = std::max({worst, std::abs(r.roll - angle(r.utime)), std::abs(r.pitch + angle(r.utime))});
      }
    }
    return compared >= 200;
  }));
  // 0.63 rad/s at most, and the servos are 30 ms late or so; the rest is this machine's.
  EXPECT_LT(worst, 0.06);
}

TEST_F(StabilizerNodeTest, AFaultIsNamedAndTheDriveRecovers) {
  ASSERT_TRUE(reaches("holding"));
  emulator_->inject(0, DriveFault::kFault);
  ASSERT_TRUE(says("roll drive (node 1) has fault 0x8611 (following error); it is reset"));
  ASSERT_TRUE(says("roll drive (node 1) works again; before: it has fault 0x8611 (following error)"));
  EXPECT_EQ(node_->status().level, Level::kDegraded);
  ASSERT_TRUE(moreReadings(5));
  EXPECT_EQ(node_->status().counters.at("roll_fault_resets"), 1);
}

TEST_F(StabilizerNodeTest, ALastingFaultIsAnError) {
  ASSERT_TRUE(reaches("holding"));
  emulator_->inject(1, DriveFault::kLastingFault);
  ASSERT_TRUE(reaches("failed"));
  EXPECT_EQ(node_->status().level, Level::kError);
  EXPECT_THAT(node_->status().detail, HasSubstr("pitch drive (node 2)"));
  ASSERT_TRUE(moreReadings(20)) << "the angles are measured on";
  emulator_->inject(1, DriveFault::kOn);
  EXPECT_TRUE(reaches("holding"));
}

TEST_F(StabilizerNodeTest, ALostHeartbeatIsNamedAndTheDriveSetUpAnew) {
  ASSERT_TRUE(reaches("holding"));
  emulator_->inject(1, DriveFault::kSilence);
  ASSERT_TRUE(says("pitch drive (node 2) sends no heartbeat"));
  EXPECT_TRUE(reaches("holding"));
}

TEST_F(StabilizerNodeTest, AnInterfaceThatGoesDownIsOpenedAgain) {
  ASSERT_TRUE(reaches("holding"));
  can_.takeDown();
  ASSERT_TRUE(says("CAN interface can0 is down (Network is down)"));
  EXPECT_EQ(node_->status().state, "failed");
  EXPECT_EQ(node_->status().level, Level::kError);
  can_.bringUp();
  startEmulator();
  ASSERT_TRUE(reaches("holding"));
  EXPECT_THAT(node_->status().detail, HasSubstr("works again; before: it is down"));
  EXPECT_GE(node_->status().counters.at("interface_failures"), 1);
}

TEST_F(StabilizerNodeTest, BusOffIsOpenedAgainAndErrorsAreSaid) {
  ASSERT_TRUE(reaches("holding"));
  can_.inject({.id = CAN_ERR_CRTL, .data = {0, CAN_ERR_CRTL_TX_PASSIVE}, .size = 8, .is_error = true});
  ASSERT_TRUE(says("CAN interface can0: the bus has many errors"));
  can_.inject({.id = CAN_ERR_BUSOFF, .size = 8, .is_error = true});
  ASSERT_TRUE(says("CAN interface can0 is bus-off"));
  ASSERT_TRUE(reaches("holding"));
  EXPECT_EQ(node_->status().counters.at("bus_errors"), 2);
}

TEST_F(StabilizerNodeTest, ALimitIsHeldAndSaid) {
  ASSERT_TRUE(reaches("holding"));
  ASSERT_TRUE(runUntil([&] {
    command(0.0, 0.5);
    return !readings_.empty() && std::abs(readings_.back().pitch - 0.35) < 0.002;
  }));
  EXPECT_THAT(node_->status().detail, HasSubstr("the pitch that is wanted is out of range"));
  EXPECT_NEAR(emulator_->angle(1), 0.35, 0.002);
}

TEST_F(StabilizerNodeTest, SteadyStateAllocatesNothing) {
  RUBBLE_NEEDS_MULTICAST();
  node_.reset();
  const std::string url = test::privateLcmUrl();
  lcm_io::LcmBus bus(url, "stabilizer");
  StabilizerNode node(bus, quickOptions(), "can0", [this] { return can_.open(); });
  const auto published = [&] {
    const auto found = bus.published().find(lcm_io::channel::kStabilizer);
    return found == bus.published().end() ? 0 : found->second.count;
  };
  const auto publishUntil = [&](std::int64_t count) {
    const auto deadline = std::chrono::steady_clock::now() + test::kDeadline;
    while (published() < count && std::chrono::steady_clock::now() < deadline) {
      bus.dispatch(milliseconds(20));
      node.advance(bus.now());
    }
    return published() >= count;
  };
  ASSERT_TRUE(publishUntil(100));
  // Where this machine stalls a queue may grow once more.
  std::int64_t allocations = 1;
  for (int i = 0; i < 5 && allocations != 0; ++i) {
    const std::int64_t before = published();
    test::watchAllocations();
    ASSERT_TRUE(publishUntil(before + 200));
    allocations = test::allocationCount();
  }
  EXPECT_EQ(allocations, 0);
}

TEST(SocketCan, WhatIsMissingIsSaid) {
  EXPECT_THAT(test::errorOf([] {
                openSocketCan("nosuchcan0", std::array{1, 2});
              }),
              AnyOf(HasSubstr("this kernel has no CAN: modprobe can-raw"),
                    HasSubstr("is not there (No such device); is the adapter plugged in")));
}

}  // namespace
}  // namespace rubble::stabilizer
