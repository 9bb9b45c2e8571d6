#include "lcm_io/log_bus.h"

#include <gmock/gmock.h>

#include <rubble/counter_t.hpp>
#include <stdexcept>

#include "bus_fixture.h"
#include "lcm_io/channels.h"
#include "lcm_io/log_file.h"
#include "sample_messages.h"
#include "support/error_text.h"
#include "support/temp_dir.h"

namespace rubble::lcm_io {
namespace {

using test::errorOf;

class LogBusTest : public testing::Test {
 protected:
  LogBusTest() {
    LogWriter writer(path_);
    auto counter = sample<rubble::counter_t>();
    for (int i = 0; i < kEvents; ++i) {
      counter.count = i;
      writer.writeMessage(kStart + 1000 * i, i % 2 == 0 ? "EVEN" : "ODD", counter);
    }
  }

  static constexpr int kEvents = 1000;
  static constexpr common::Utime kStart = 1'700'000'000'000'000;

  test::TempDir dir_;
  std::filesystem::path path_ = dir_.path() / "a.lcm";
  const std::string url_ = "file://" + path_.string() + "?speed=0";
};

TEST_F(LogBusTest, EveryMessageArrivesAtItsTime) {
  LogBus bus(url_);
  std::vector<std::int64_t> seen;
  bus.subscribe<rubble::counter_t>("EVEN", [&](const rubble::counter_t& m) {
    seen.push_back(m.count);
    EXPECT_EQ(bus.now(), kStart + 1000 * m.count);
  });
  ASSERT_TRUE(dispatchUntil(bus, [&] { return bus.ended(); }));
  ASSERT_EQ(seen.size(), kEvents / 2U);
  EXPECT_EQ(seen.back(), kEvents - 2);
  EXPECT_EQ(bus.received().at("EVEN").dropped, 0);
  EXPECT_FALSE(bus.dispatch(std::chrono::milliseconds(0)));
}

TEST_F(LogBusTest, NothingIsPublishedIntoALog) {
  LogBus bus(url_);
  bus.publish(channel::kRobotPose, sample<rubble::counter_t>());
  EXPECT_EQ(bus.published().at(channel::kRobotPose).count, 0);
  EXPECT_EQ(bus.published().at(channel::kRobotPose).dropped, 1);
}

TEST_F(LogBusTest, AHandlersExceptionComesThrough) {
  LogBus bus(url_);
  bus.subscribeRaw("EVEN", [](const RawMessage&) { throw std::logic_error("broken"); });
  EXPECT_THROW(dispatchUntil(bus, [&] { return bus.ended(); }), std::logic_error);
}

TEST_F(LogBusTest, StopReceivingEndsIt) {
  LogBus bus(url_);
  EXPECT_TRUE(bus.dispatch(std::chrono::milliseconds(0)));
  bus.stopReceiving();
  EXPECT_FALSE(bus.dispatch(std::chrono::milliseconds(0)));
  EXPECT_TRUE(bus.ended());
}

TEST_F(LogBusTest, WhatIsNoLogOrNoPlainUrlIsAnError) {
  EXPECT_EQ(errorOf([] { LogBus("file:///nonexistent/a.lcm?speed=0"); }),
            "/nonexistent/a.lcm: log cannot be read");
  EXPECT_EQ(
      errorOf([&] { LogBus("file://a.lcm?speed=2"); }),
      "--lcm-url file://a.lcm?speed=2: a log is read as fast as it is handled; write file://a.lcm?speed=0");
  EXPECT_EQ(errorOf([&] { LcmBus(url_, "play"); }), "--lcm-url " + url_ + ": a log is no live bus");
}

}  // namespace
}  // namespace rubble::lcm_io
