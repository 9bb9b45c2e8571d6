#include "lcm_io/health_reporter.h"

#include <gmock/gmock.h>
#include <unistd.h>

#include <cmath>
#include <rubble/odometry_t.hpp>

#include "lcm_io/channels.h"
#include "lcm_io/replay_hub.h"
#include "sample_messages.h"

namespace rubble::lcm_io {
namespace {

using testing::HasSubstr;

constexpr common::Utime kStart = 1'000'000'000;

class HealthReporterTest : public testing::Test {
 protected:
  HealthReporterTest() {
    hub_.advanceTo(kStart);
    bus_.subscribe<rubble::odometry_t>(channel::kOdometry, [](const rubble::odometry_t&) {});
  }

  void feedOdometry(common::Utime utime, common::Utime latency) {
    auto odometry = sample<rubble::odometry_t>();
    odometry.utime = utime;
    hub_.feed({channel::kOdometry, utime + latency, encode(odometry)});
  }
  void feedGarbage() { hub_.feed({channel::kOdometry, hub_.now(), {1, 2, 3}}); }
  rubble::health_t reportAt(common::Utime utime) {
    hub_.advanceTo(utime);
    return reporter_.report(bus_, status_);
  }
  static rubble::channel_health_t find(const rubble::health_t& health, const std::string& name,
                                       std::int8_t direction) {
    for (const auto& c : health.channels) {
      if (c.channel == name && c.direction == direction) {
        return c;
      }
    }
    ADD_FAILURE() << name << " is not in HEALTH";
    return sample<rubble::channel_health_t>();
  }

  ReplayHub hub_;
  Bus& bus_ = hub_.endpoint();
  HealthReporter reporter_{"fusion", kStart};
  NodeStatus status_{NodeStatus::Level::kOk, "running", "", {{"scans", 3}, {"losses", 0}}};
};

TEST_F(HealthReporterTest, SaysWhoAndHow) {
  const rubble::health_t health = reportAt(kStart + 500);
  EXPECT_EQ(health.utime, kStart + 500);
  EXPECT_EQ(health.start_utime, kStart);
  EXPECT_EQ(health.process, "fusion");
  EXPECT_EQ(health.pid, ::getpid());
  EXPECT_EQ(health.level, rubble::health_t::LEVEL_OK);
  EXPECT_EQ(health.state, "running");
  EXPECT_EQ(health.detail, "");
  EXPECT_GT(health.memory_bytes, 100'000);
  EXPECT_GT(health.cpu_seconds, 0.0);
  ASSERT_EQ(health.ncounters, 2);
  EXPECT_EQ(health.counters[1].name, "scans");
  EXPECT_EQ(health.counters[1].count, 3);
  EXPECT_EQ(encode(decode<rubble::health_t>(encode(health))), encode(health));
}

TEST_F(HealthReporterTest, CountsAreSinceTheStartRateAndLatencySinceTheLastReport) {
  for (int i = 0; i < 20; ++i) {
    feedOdometry(kStart + 100'000 * i, 1000 * (1 + i % 2 * 4));
  }
  const auto first =
      find(reportAt(kStart + 2'000'000), channel::kOdometry, rubble::channel_health_t::RECEIVED);
  EXPECT_EQ(first.count, 20);
  EXPECT_FLOAT_EQ(first.rate_hz, 10.0F);
  EXPECT_FLOAT_EQ(first.latency_mean_ms, 3.0F);
  EXPECT_FLOAT_EQ(first.latency_max_ms, 5.0F);

  const auto second =
      find(reportAt(kStart + 3'000'000), channel::kOdometry, rubble::channel_health_t::RECEIVED);
  EXPECT_EQ(second.count, 20);
  EXPECT_FLOAT_EQ(second.rate_hz, 0.0F);
  EXPECT_TRUE(std::isnan(second.latency_mean_ms));
  EXPECT_FLOAT_EQ(second.latency_max_ms, 0.0F);
}

TEST_F(HealthReporterTest, WhatIsPublishedIsCounted) {
  for (int i = 0; i < 5; ++i) {
    bus_.publish(channel::kRobotPose, sample<rubble::robot_pose_t>());
  }
  const auto c = find(reportAt(kStart + 500'000), channel::kRobotPose, rubble::channel_health_t::PUBLISHED);
  EXPECT_EQ(c.count, 5);
  EXPECT_FLOAT_EQ(c.rate_hz, 10.0F);
  EXPECT_TRUE(std::isnan(c.latency_mean_ms));
}

TEST_F(HealthReporterTest, TwoReportsAtOneTimeHaveNoRate) {
  feedOdometry(kStart, 0);
  EXPECT_FLOAT_EQ(find(reportAt(kStart), channel::kOdometry, rubble::channel_health_t::RECEIVED).rate_hz,
                  0.0F);
}

TEST_F(HealthReporterTest, RefusedMessagesDegradeUntilAnIntervalWithout) {
  feedGarbage();
  feedGarbage();
  const rubble::health_t degraded = reportAt(kStart + 1'000'000);
  EXPECT_EQ(degraded.level, rubble::health_t::LEVEL_DEGRADED);
  EXPECT_THAT(degraded.detail, HasSubstr("2 messages refused on ODOMETRY: 3 bytes that are no odometry_t"));
  EXPECT_EQ(find(degraded, channel::kOdometry, rubble::channel_health_t::RECEIVED).errors, 2);

  feedOdometry(kStart + 1'500'000, 0);
  const rubble::health_t recovered = reportAt(kStart + 2'000'000);
  EXPECT_EQ(recovered.level, rubble::health_t::LEVEL_OK);
  EXPECT_EQ(recovered.detail, "");
  EXPECT_EQ(find(recovered, channel::kOdometry, rubble::channel_health_t::RECEIVED).errors, 2);
}

TEST_F(HealthReporterTest, TheNodesOwnWordComesFirstAndItsErrorStaysAnError) {
  status_.level = NodeStatus::Level::kError;
  status_.detail = "no scans";
  feedGarbage();
  const rubble::health_t health = reportAt(kStart + 1'000'000);
  EXPECT_EQ(health.level, rubble::health_t::LEVEL_ERROR);
  EXPECT_THAT(health.detail, testing::StartsWith("no scans; 1 messages refused"));
}

/// A bus that lost messages and whose channel another process took.
class TroubledBus : public Bus {
 public:
  bool dispatch(std::chrono::milliseconds /*timeout*/) override { return false; }
  bool ended() const override { return false; }
  common::Utime now() const override { return kStart + 1; }
  std::string conflict() const override { return conflict_; }

  void drop(std::int64_t count) { noteDropped(channel::kCamera, count); }
  std::string conflict_;

 private:
  void attach(const std::string& /*channel*/) override {}
  bool send(const std::string& /*channel*/, ByteView /*data*/) override { return true; }
};

TEST_F(HealthReporterTest, AConflictIsAnErrorThatNamesTheChannel) {
  TroubledBus bus;
  bus.conflict_ = "ROBOT_POSE";
  const rubble::health_t health = reporter_.report(bus, status_);
  EXPECT_EQ(health.level, rubble::health_t::LEVEL_ERROR);
  EXPECT_THAT(health.detail, HasSubstr("another process publishes ROBOT_POSE"));
}

TEST_F(HealthReporterTest, DroppedMessagesDegradeUntilAnIntervalWithout) {
  TroubledBus bus;
  bus.drop(7);
  const rubble::health_t degraded = reporter_.report(bus, status_);
  EXPECT_EQ(degraded.level, rubble::health_t::LEVEL_DEGRADED);
  EXPECT_THAT(degraded.detail, HasSubstr("7 messages of CAMERA dropped"));
  EXPECT_EQ(reporter_.report(bus, status_).level, rubble::health_t::LEVEL_OK);
}

}  // namespace
}  // namespace rubble::lcm_io
