#include "lcm_io/replay_hub.h"

#include <gmock/gmock.h>

#include <rubble/counter_t.hpp>
#include <rubble/odometry_t.hpp>

#include "sample_messages.h"

namespace rubble::lcm_io {
namespace {

using testing::ElementsAre;

RawMessage message(const std::string& channel, common::Utime utime, std::int64_t count) {
  rubble::counter_t counter;
  counter.name = channel;
  counter.count = count;
  return {channel, utime, encode(counter)};
}

class ReplayHubTest : public testing::Test {
 protected:
  /// Notes `endpoint:channel:count@now` for every message.
  void note(Bus& bus, const std::string& endpoint, const std::string& channel) {
    bus.subscribe<rubble::counter_t>(channel, [this, &bus, endpoint, channel](const rubble::counter_t& m) {
      seen_.push_back(fmt::format("{}:{}:{}@{}", endpoint, channel, m.count, bus.now()));
    });
  }

  ReplayHub hub_;
  std::vector<std::string> seen_;
};

TEST_F(ReplayHubTest, DeliversToEveryEndpointInOrder) {
  Bus& a = hub_.endpoint();
  Bus& b = hub_.endpoint();
  note(a, "a", "X");
  note(b, "b", "X");
  note(b, "b", "Y");
  hub_.feed(message("X", 10, 1));
  hub_.feed(message("Y", 20, 2));
  hub_.feed(message("Z", 30, 3));
  EXPECT_THAT(seen_, ElementsAre("a:X:1@10", "b:X:1@10", "b:Y:2@20"));
  EXPECT_EQ(hub_.now(), 30);
}

TEST_F(ReplayHubTest, WhatAHandlerPublishesComesAfterWhatIsUnderWay) {
  Bus& a = hub_.endpoint();
  Bus& b = hub_.endpoint();
  a.subscribe<rubble::counter_t>("X", [&](const rubble::counter_t& m) {
    seen_.push_back("a:X");
    a.publish("Y", m);
  });
  note(b, "b", "Y");
  note(b, "b", "X");
  hub_.feed(message("X", 5, 1));
  EXPECT_THAT(seen_, ElementsAre("a:X", "b:X:1@5", "b:Y:1@5"));
  EXPECT_EQ(a.published().at("Y").count, 1);
}

TEST_F(ReplayHubTest, WhatIsPublishedOutsideWaitsForDeliverPending) {
  Bus& a = hub_.endpoint();
  note(a, "a", "X");
  hub_.advanceTo(7);
  a.publish("X", sample<rubble::counter_t>());
  EXPECT_TRUE(seen_.empty());
  hub_.deliverPending();
  EXPECT_THAT(seen_, ElementsAre("a:X:-3@7"));
}

TEST_F(ReplayHubTest, TimeNeverGoesBack) {
  Bus& a = hub_.endpoint();
  note(a, "a", "X");
  hub_.feed(message("X", 100, 1));
  hub_.feed(message("X", 50, 2));
  hub_.advanceTo(20);
  EXPECT_EQ(hub_.now(), 100);
  EXPECT_THAT(seen_, ElementsAre("a:X:1@100", "a:X:2@100"));
}

TEST_F(ReplayHubTest, TwoRunsAreIdentical) {
  const auto run = [] {
    ReplayHub hub;
    Bus& a = hub.endpoint();
    Bus& b = hub.endpoint();
    std::vector<std::string> log;
    const auto relay = [&log](Bus& bus, const std::string& from, const std::string& to) {
      bus.subscribe<rubble::counter_t>(from, [&bus, &log, from, to](const rubble::counter_t& m) {
        log.push_back(fmt::format("{}{}@{}", from, m.count, bus.now()));
        if (m.count % 3 != 0) {
          rubble::counter_t next = m;
          next.count += 1;
          bus.publish(to, next);
        }
      });
    };
    relay(a, "X", "Y");
    relay(b, "Y", "X");
    relay(b, "Z", "X");
    for (int i = 0; i < 50; ++i) {
      hub.feed(message(i % 2 == 0 ? "X" : "Z", 10 * i, i));
    }
    return log;
  };
  const auto log = run();
  EXPECT_GT(log.size(), 50U);
  EXPECT_EQ(log, run());
}

TEST_F(ReplayHubTest, RefusedMessagesAreCountedAndTheRestGoesOn) {
  Bus& a = hub_.endpoint();
  note(a, "a", "X");
  a.subscribe<rubble::counter_t>("BAD",
                                 [](const rubble::counter_t&) { throw common::Error("nonsense inside"); });
  hub_.feed({"X", 1, encode(sample<rubble::odometry_t>())});
  hub_.feed({"X", 2, {1, 2, 3}});
  hub_.feed(message("BAD", 3, 1));
  hub_.feed(message("X", 4, 5));
  EXPECT_EQ(a.received().at("X").count, 3);
  EXPECT_EQ(a.received().at("X").errors, 2);
  EXPECT_THAT(a.received().at("X").last_error, testing::HasSubstr("3 bytes that are no counter_t"));
  EXPECT_EQ(a.received().at("BAD").errors, 1);
  EXPECT_EQ(a.received().at("BAD").last_error, "nonsense inside");
  EXPECT_THAT(seen_, ElementsAre("a:X:5@4"));
}

TEST_F(ReplayHubTest, LatencyIsFromTheMessagesTimeToItsHandling) {
  Bus& a = hub_.endpoint();
  a.subscribe<rubble::odometry_t>("ODOMETRY", [](const rubble::odometry_t&) {});
  auto odometry = sample<rubble::odometry_t>();
  for (const int latency : {2000, 6000}) {
    hub_.feed({"ODOMETRY", odometry.utime + latency, encode(odometry)});
  }
  const ChannelStats stats = a.received().at("ODOMETRY");
  EXPECT_EQ(stats.latency_count, 2);
  EXPECT_DOUBLE_EQ(stats.latency_sum_ms, 8.0);
  EXPECT_DOUBLE_EQ(stats.latency_max_ms, 6.0);
  a.resetLatency();
  EXPECT_EQ(a.received().at("ODOMETRY").latency_count, 0);
  EXPECT_EQ(a.received().at("ODOMETRY").count, 2);
}

TEST_F(ReplayHubTest, SubscribeAllHearsWhatHasNoHandlerOfItsOwn) {
  Bus& a = hub_.endpoint();
  note(a, "a", "X");
  a.subscribeAll([this](const RawMessage& raw) { seen_.push_back("all:" + raw.channel); });
  hub_.feed(message("X", 1, 1));
  hub_.feed(message("Y", 2, 1));
  EXPECT_THAT(seen_, ElementsAre("a:X:1@1", "all:Y"));
}

TEST(ReplayHubDeathTest, ASecondHandlerForAChannelIsABrokenInvariant) {
  ReplayHub hub;
  Bus& bus = hub.endpoint();
  bus.subscribeRaw("X", [](const RawMessage&) {});
  EXPECT_DEATH(bus.subscribeRaw("X", [](const RawMessage&) {}), "broken invariant: inserted");
}

}  // namespace
}  // namespace rubble::lcm_io
