#include "console_node.h"

#include <gtest/gtest.h>

#include "common/error.h"
#include "lcm_io/channels.h"
#include "lcm_io/replay_hub.h"
#include "log_content.h"

namespace rubble::ops_console {
namespace {

constexpr common::Utime kSecond = common::kMicrosecondsPerSecond;

class ChannelSink : public LogSink {
 public:
  explicit ChannelSink(std::vector<std::string>& channels) : channels_(channels) {}
  void write(const std::vector<lcm_io::RawMessage>& batch) override {
    for (const lcm_io::RawMessage& message : batch) {
      channels_.push_back(message.channel);
    }
  }
  void sync() override {}

 private:
  std::vector<std::string>& channels_;
};

class RefusingSink : public LogSink {
 public:
  void write(const std::vector<lcm_io::RawMessage>& batch) override {
    if (!batch.empty()) {
      throw common::Error("disk full: /logs has 0 kB left; free space or lower ops_console.quota_mb");
    }
  }
  void sync() override {}
};

class ConsoleNodeTest : public testing::Test {
 protected:
  void makeNode(std::unique_ptr<LogSink> sink) {
    node_ = std::make_unique<ConsoleNode>(hub_.endpoint(), std::move(sink), 1'000'000);
  }
  void feedHealth(const std::string& process, std::int8_t level, common::Utime utime, std::int64_t scans) {
    rubble::health_t health{};
    health.utime = utime;
    health.process = process;
    health.level = level;
    health.state = "lost";
    health.detail = "no picture for 2 s";
    rubble::channel_health_t channel{};
    channel.channel = "SCAN";
    channel.direction = rubble::channel_health_t::PUBLISHED;
    channel.count = scans;
    health.channels = {channel};
    health.nchannels = 1;
    hub_.feed({lcm_io::channel::kHealth, utime, lcm_io::encode(health)});
  }

  lcm_io::ReplayHub hub_;
  std::vector<std::string> logged_;
  std::unique_ptr<ConsoleNode> node_;
};

TEST_F(ConsoleNodeTest, LogsAllButWhatTheTableExcludes) {
  makeNode(std::make_unique<ChannelSink>(logged_));
  for (const char* channel : {"SCAN", "MONO_FEATURES", "SOMETHING_NEW", "HEALTH"}) {
    hub_.feed(numbered(channel, 0, 100, kSecond));
  }
  node_->finish();
  EXPECT_EQ(logged_, (std::vector<std::string>{"SCAN", "SOMETHING_NEW", "HEALTH"}));
  EXPECT_EQ(node_->status().counters.at("logged"), 3);
}

TEST_F(ConsoleNodeTest, NamesProcessesInTrouble) {
  makeNode(std::make_unique<ChannelSink>(logged_));
  feedHealth("slam_mono", rubble::health_t::LEVEL_DEGRADED, kSecond, 0);
  feedHealth("lidar", rubble::health_t::LEVEL_OK, kSecond, 0);
  lcm_io::NodeStatus status = node_->status();
  EXPECT_EQ(status.state, "logging");
  EXPECT_EQ(status.level, lcm_io::NodeStatus::Level::kDegraded);
  EXPECT_EQ(status.detail, "slam_mono is degraded (lost): no picture for 2 s");
  feedHealth("slam_mono", rubble::health_t::LEVEL_OK, 6 * kSecond, 0);
  status = node_->status();
  EXPECT_EQ(status.detail, "lidar is silent for 5 s");
}

TEST_F(ConsoleNodeTest, ReportsWhatTheBusLost) {
  makeNode(std::make_unique<ChannelSink>(logged_));
  feedHealth("lidar", rubble::health_t::LEVEL_OK, kSecond, 0);
  feedHealth("lidar", rubble::health_t::LEVEL_OK, 2 * kSecond, 4);
  feedHealth("lidar", rubble::health_t::LEVEL_OK, 3 * kSecond, 4);
  lcm_io::NodeStatus status = node_->status();
  EXPECT_EQ(status.counters.at("lost_SCAN"), 4);
  EXPECT_EQ(status.counters.at("lost_total"), 4);
  EXPECT_EQ(status.level, lcm_io::NodeStatus::Level::kDegraded);
  EXPECT_NE(status.detail.find("SCAN 4"), std::string::npos) << status.detail;
  for (int second = 4; second < 15; ++second) {
    feedHealth("lidar", rubble::health_t::LEVEL_OK, second * kSecond, 4);
  }
  EXPECT_EQ(node_->status().level, lcm_io::NodeStatus::Level::kOk) << "old news";
  EXPECT_EQ(node_->status().counters.at("lost_SCAN"), 4);
}

TEST_F(ConsoleNodeTest, DiskThatRefusesIsAnError) {
  makeNode(std::make_unique<RefusingSink>());
  hub_.feed(numbered("SCAN", 0, 100, kSecond));
  node_->finish();
  const lcm_io::NodeStatus status = node_->status();
  EXPECT_EQ(status.level, lcm_io::NodeStatus::Level::kError);
  EXPECT_NE(status.detail.find("free space or lower ops_console.quota_mb"), std::string::npos);
  EXPECT_EQ(status.counters.at("log_dropped"), 1);
}

}  // namespace
}  // namespace rubble::ops_console
