#include "console_node.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <filesystem>

#include "common/files.h"
#include "common/robot_config.h"
#include "lcm_io/channels.h"
#include "log_store.h"

namespace rubble::ops_console {

namespace {

using Level = lcm_io::NodeStatus::Level;

constexpr char kProcess[] = "ops_console";
constexpr common::Utime kLossIsNews = 10 * common::kMicrosecondsPerSecond;
constexpr std::chrono::seconds kStall{2};
constexpr std::int64_t kMegabyte = 1'000'000;

std::string complaintOf(const rubble::health_t& health) {
  if (health.level == rubble::health_t::LEVEL_OK) {
    return {};
  }
  return fmt::format("{} ({}): {}",
                     health.level == rubble::health_t::LEVEL_DEGRADED ? "is degraded" : "has an error",
                     health.state, health.detail);
}

/// A log's calibration stands beside it, for `rubble replay`. Without it the log is still worth having.
void writeCalibration(const std::filesystem::path& log_dir, const common::Config& config) {
  const std::string robot = config.describe<common::RobotConfig>("robot");
  try {
    std::filesystem::create_directories(log_dir);
    common::writeFileAtomically(log_dir / "robot.yaml", robot);
  } catch (const std::exception& e) {
    spdlog::warn("the calibration is not beside the logs: {}", e.what());
  }
}

void raise(lcm_io::NodeStatus& status, Level level, const std::string& detail) {
  status.level = std::max(status.level, level);
  status.detail += (status.detail.empty() ? "" : "; ") + detail;
}

}  // namespace

ConsoleNode::ConsoleNode(lcm_io::Bus& bus, std::unique_ptr<LogSink> sink, std::size_t queue_bytes)
    : bus_(bus), writer_(std::move(sink), queue_bytes) {
  bus_.subscribeAll([this](const lcm_io::RawMessage& message) { onMessage(message); });
}

void ConsoleNode::onMessage(const lcm_io::RawMessage& message) {
  const lcm_io::ChannelInfo* info = lcm_io::findChannel(message.channel);
  if (info == nullptr || info->logged) {
    writer_.push(message);
  }
  if (message.channel == lcm_io::channel::kHealth) {
    onHealth(lcm_io::decode<rubble::health_t>(message.data));
  } else {
    losses_.received(message.channel);
  }
}

void ConsoleNode::onHealth(const rubble::health_t& health) {
  PublisherReport report{health.process, health.pid, health.start_utime, {}};
  for (const rubble::channel_health_t& c : health.channels) {
    if (c.direction == rubble::channel_health_t::PUBLISHED) {
      report.published[c.channel] = c.count;
    }
  }
  if (losses_.report(report) > 0) {
    last_loss_utime_ = bus_.now();
  }
  if (health.process != kProcess) {
    watch_.update(health.process, complaintOf(health), bus_.now());
  }
}

lcm_io::NodeStatus ConsoleNode::status() const {
  const AsyncWriter::Status log = writer_.status();
  lcm_io::NodeStatus status{Level::kOk, "logging", {}, {}};
  status.counters = {
      {"logged", log.written}, {"logged_bytes", log.written_bytes}, {"log_dropped", log.dropped}};
  std::int64_t lost_total = 0;
  std::string lost_list;
  for (const auto& [channel, count] : losses_.lost()) {
    status.counters["lost_" + channel] = count;
    lost_total += count;
    lost_list += fmt::format(" {} {}", channel, count);
  }
  status.counters["lost_total"] = lost_total;

  if (!log.error.empty()) {
    raise(status, Level::kError, log.error);
  } else if (log.busy > kStall) {
    raise(
        status, Level::kError,
        fmt::format("the disk has not answered for {} s, {} MB wait, {} messages dropped; use a faster disk",
                    std::chrono::duration_cast<std::chrono::seconds>(log.busy).count(),
                    static_cast<std::int64_t>(log.queued_bytes) / kMegabyte, log.dropped));
  }
  if (last_loss_utime_ != 0 && bus_.now() - last_loss_utime_ < kLossIsNews) {
    raise(status, Level::kDegraded,
          fmt::format("the bus loses messages, since the start:{}; raise net.core.rmem_max or lower the load",
                      lost_list));
  }
  for (const std::string& problem : watch_.problems(bus_.now())) {
    raise(status, Level::kDegraded, problem);
  }
  return status;
}

std::unique_ptr<lcm_io::Node> makeConsoleNode(const lcm_io::ProcessContext& context) {
  const auto config = context.config.read<OpsConsoleConfig>(kProcess);
  writeCalibration(config.log_dir, context.config);
  const LogLimits limits{config.quota_mb * kMegabyte, config.rotate_mb * kMegabyte,
                         config.rotate_s * common::kMicrosecondsPerSecond};
  return std::make_unique<ConsoleNode>(context.bus, std::make_unique<LogStore>(config.log_dir, limits),
                                       static_cast<std::size_t>(config.queue_mb * kMegabyte));
}

}  // namespace rubble::ops_console
