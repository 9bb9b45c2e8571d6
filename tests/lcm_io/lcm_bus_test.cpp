#include "lcm_io/lcm_bus.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <rubble/command_t.hpp>
#include <rubble/counter_t.hpp>
#include <thread>

#include "bus_fixture.h"
#include "lcm_io/channels.h"
#include "sample_messages.h"
#include "support/error_text.h"

namespace rubble::lcm_io {
namespace {

using test::errorOf;
using test::waitUntil;

rubble::counter_t counter(std::int64_t count) {
  auto m = sample<rubble::counter_t>();
  m.count = count;
  return m;
}

class LcmBusTest : public LiveBusTest {
 protected:
  /// Notes the counts that arrive on a channel.
  void note(Bus& bus, const std::string& channel) {
    bus.subscribe<rubble::counter_t>(channel,
                                     [this](const rubble::counter_t& m) { seen_.push_back(m.count); });
  }
  void drain(LcmBus& bus) {
    bus.stopReceiving();
    while (bus.dispatch(std::chrono::milliseconds(0))) {
    }
  }

  std::vector<std::int64_t> seen_;
};

TEST_F(LcmBusTest, PublishedMessagesArriveInOrder) {
  LcmBus publisher(url_, "test");
  LcmBus subscriber(url_, "other");
  note(subscriber, "NUMBERS");
  for (int i = 0; i < 200; ++i) {
    publisher.publish("NUMBERS", counter(i));
  }
  ASSERT_TRUE(dispatchUntil(subscriber, [&] { return seen_.size() == 200; }));
  EXPECT_TRUE(std::is_sorted(seen_.begin(), seen_.end()));
  EXPECT_EQ(publisher.published().at("NUMBERS").count, 200);
  EXPECT_EQ(subscriber.received().at("NUMBERS").count, 200);
  EXPECT_EQ(subscriber.received().at("NUMBERS").dropped, 0);
}

TEST_F(LcmBusTest, WakeEndsADispatchThatWaits) {
  LcmBus bus(url_, "test");
  std::thread waker([&] { bus.wake(); });
  const auto start = std::chrono::steady_clock::now();
  EXPECT_FALSE(bus.dispatch(std::chrono::minutes(1)));
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(30));
  waker.join();
}

TEST_F(LcmBusTest, AMessageOfMegabytesArrives) {
  LcmBus publisher(url_, "test");
  LcmBus subscriber(url_, "other");
  std::size_t size = 0;
  subscriber.subscribeRaw("LARGE", [&](const RawMessage& raw) { size = raw.data.size(); });
  publisher.publishRaw("LARGE", Bytes(1'000'000, 5));
  EXPECT_TRUE(dispatchUntil(subscriber, [&] { return size == 1'000'000; }));
}

TEST_F(LcmBusTest, ALateConsumerGetsTheNewestAndTheRestIsCounted) {
  LcmBus publisher(url_, "test");
  LcmBus subscriber(url_, "slam_mono");
  note(subscriber, channel::kCamera);
  const auto capacity = static_cast<std::int64_t>(findChannel(channel::kCamera)->queue_capacity);
  for (int i = 0; i < 50; ++i) {
    publisher.publish(channel::kCamera, counter(i));
  }
  drain(subscriber);
  std::vector<std::int64_t> newest;
  for (std::int64_t i = 50 - capacity; i < 50; ++i) {
    newest.push_back(i);
  }
  EXPECT_EQ(seen_, newest);
  EXPECT_EQ(subscriber.received().at(channel::kCamera).count, capacity);
  EXPECT_EQ(subscriber.received().at(channel::kCamera).dropped, 50 - capacity);
}

TEST_F(LcmBusTest, ABusyChannelDoesNotPushOutAnother) {
  LcmBus publisher(url_, "test");
  LcmBus subscriber(url_, "slam_mono");
  note(subscriber, channel::kCamera);
  int commands = 0;
  subscriber.subscribe<rubble::command_t>(channel::kCommand, [&](const rubble::command_t&) { ++commands; });
  publisher.publish(channel::kCommand, sample<rubble::command_t>());
  for (int i = 0; i < 50; ++i) {
    publisher.publish(channel::kCamera, counter(i));
  }
  drain(subscriber);
  EXPECT_EQ(commands, 1);
}

TEST_F(LcmBusTest, StopReceivingKeepsWhatHasArrivedAndTakesNothingMore) {
  LcmBus publisher(url_, "test");
  LcmBus subscriber(url_, "other");
  note(subscriber, "NUMBERS");
  for (int i = 0; i < 100; ++i) {
    publisher.publish("NUMBERS", counter(i));
  }
  subscriber.stopReceiving();
  publisher.publish("NUMBERS", counter(1000));
  drain(subscriber);
  EXPECT_EQ(seen_.size(), 100U);
  EXPECT_EQ(seen_.back(), 99);
}

TEST_F(LcmBusTest, StopReceivingEndsUnderSteadyTraffic) {
  LcmBus publisher(url_, "test");
  LcmBus subscriber(url_, "other");
  note(subscriber, "NUMBERS");
  std::atomic<bool> enough = false;
  std::thread traffic([&] {
    while (!enough) {
      publisher.publish("NUMBERS", counter(1));
      std::this_thread::sleep_for(std::chrono::milliseconds(1));  // The traffic's rate, not a wait.
    }
  });
  EXPECT_TRUE(dispatchUntil(subscriber, [&] { return seen_.size() > 20; }));
  const auto start = std::chrono::steady_clock::now();
  subscriber.stopReceiving();
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(1));
  enough = true;
  traffic.join();
}

TEST_F(LcmBusTest, WhoHearsAnotherPublisherOnItsChannelStops) {
  LcmBus first(url_, "fusion");
  LcmBus listener(url_, "other");
  note(listener, channel::kRobotPose);
  first.publish(channel::kRobotPose, counter(1));
  ASSERT_TRUE(dispatchUntil(listener, [&] { return seen_.size() == 1; }));
  EXPECT_EQ(first.conflict(), "") << "its own message is no foreign one";

  LcmBus second(url_, "fusion");  // Opened only now: what was sent before it existed cannot reach it.
  second.publish(channel::kRobotPose, counter(2));
  ASSERT_TRUE(waitUntil([&] { return !first.conflict().empty(); }));
  EXPECT_EQ(first.conflict(), channel::kRobotPose);
  first.publish(channel::kRobotPose, counter(3));
  first.publish(channel::kLidarControl, counter(4));
  EXPECT_EQ(first.published().at(channel::kRobotPose).count, 1);
  EXPECT_EQ(first.published().at(channel::kRobotPose).dropped, 1);
  EXPECT_EQ(first.published().at(channel::kLidarControl).count, 1) << "the other channels go on";

  second.publish(channel::kRobotPose, counter(5));
  ASSERT_TRUE(dispatchUntil(listener, [&] { return seen_.back() == 5; }));
  EXPECT_THAT(seen_, testing::ElementsAre(1, 2, 5));
  EXPECT_EQ(second.conflict(), "") << "it has heard nobody else since it began";
}

TEST_F(LcmBusTest, ABurstOfOwnMessagesIsNoConflict) {
  LcmBus bus(url_, "fusion");
  std::int64_t last = 0;
  bus.subscribe<rubble::counter_t>(channel::kRobotPose, [&](const rubble::counter_t& m) { last = m.count; });
  for (int i = 1; i <= 2000; ++i) {
    bus.publish(channel::kRobotPose, counter(i));
  }
  EXPECT_TRUE(dispatchUntil(bus, [&] { return last == 2000; }));
  EXPECT_EQ(bus.conflict(), "");
}

TEST_F(LcmBusTest, OnHealthEverybodyPublishes) {
  LcmBus first(url_, "fusion");
  LcmBus second(url_, "slam_mono");
  int heard_first = 0;
  int heard_second = 0;
  first.subscribe<rubble::counter_t>(channel::kHealth, [&](const rubble::counter_t&) { ++heard_first; });
  second.subscribe<rubble::counter_t>(channel::kHealth, [&](const rubble::counter_t&) { ++heard_second; });
  first.publish(channel::kHealth, counter(1));
  second.publish(channel::kHealth, counter(2));
  ASSERT_TRUE(dispatchUntil(first, [&] { return heard_first == 2; }));
  ASSERT_TRUE(dispatchUntil(second, [&] { return heard_second == 2; }));
  EXPECT_EQ(first.conflict() + second.conflict(), "");
}

TEST_F(LcmBusTest, SubscribeAllHearsEveryChannelOnce) {
  LcmBus publisher(url_, "test");
  LcmBus console(url_, "ops_console");
  std::map<std::string, int> heard;
  console.subscribeAll([&](const RawMessage& raw) { ++heard[raw.channel]; });
  note(console, channel::kHealth);
  publisher.publish("ANYTHING", counter(1));
  publisher.publish(channel::kScan, counter(1));
  publisher.publish(channel::kHealth, counter(1));
  publisher.publish("LAST", counter(1));
  ASSERT_TRUE(dispatchUntil(console, [&] { return heard.contains("LAST"); }));
  EXPECT_EQ(heard["ANYTHING"], 1);
  EXPECT_EQ(heard[channel::kScan], 1);
  EXPECT_EQ(seen_.size(), 1U);
}

TEST_F(LcmBusTest, LatencyIsMeasuredAgainstTheClock) {
  LcmBus publisher(url_, "test");
  LcmBus subscriber(url_, "other");
  subscriber.subscribe<rubble::command_t>(channel::kCommand, [](const rubble::command_t&) {});
  auto command = sample<rubble::command_t>();
  command.utime = publisher.now() - 100'000;
  publisher.publish(channel::kCommand, command);
  ASSERT_TRUE(
      dispatchUntil(subscriber, [&] { return subscriber.received().at(channel::kCommand).count == 1; }));
  EXPECT_GE(subscriber.received().at(channel::kCommand).latency_max_ms, 100.0);
}

TEST(LcmBusMemq, TalksToItself) {
  LcmBus bus("memq://", "test");
  std::vector<std::int64_t> seen;
  bus.subscribe<rubble::counter_t>("NUMBERS", [&](const rubble::counter_t& m) { seen.push_back(m.count); });
  for (int i = 0; i < 10; ++i) {
    bus.publish("NUMBERS", counter(i));
  }
  EXPECT_TRUE(dispatchUntil(bus, [&] { return seen.size() == 10; }));
  EXPECT_FALSE(bus.ended());
}

TEST(LcmBusUrl, WhatLcmDoesNotTakeIsAnError) {
  EXPECT_EQ(errorOf([] { LcmBus("carrier-pigeon://", "test"); }),
            std::string("--lcm-url carrier-pigeon://: LCM cannot open it; the default is ") + kDefaultLcmUrl);
}

}  // namespace
}  // namespace rubble::lcm_io
