#include "lcm_io/health_reporter.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cmath>
#include <fstream>
#include <limits>

namespace rubble::lcm_io {

namespace {

std::int64_t residentBytes() {
  std::ifstream statm("/proc/self/statm");
  std::int64_t total = 0;
  std::int64_t resident = 0;
  statm >> total >> resident;
  return resident * ::sysconf(_SC_PAGESIZE);
}

double cpuSeconds() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

void degrade(rubble::health_t& health, std::int8_t level, const std::string& detail) {
  health.level = std::max(health.level, level);
  health.detail += (health.detail.empty() ? "" : "; ") + detail;
}

}  // namespace

HealthReporter::HealthReporter(std::string process, common::Utime start_utime)
    : process_(std::move(process)), start_utime_(start_utime), last_utime_(start_utime) {}

rubble::health_t HealthReporter::report(Bus& bus, const NodeStatus& status) {
  rubble::health_t health;
  health.utime = bus.now();
  health.process = process_;
  health.pid = ::getpid();
  health.start_utime = start_utime_;
  health.level = static_cast<std::int8_t>(status.level);
  health.state = status.state;
  health.detail = status.detail;
  health.memory_bytes = residentBytes();
  health.cpu_seconds = cpuSeconds();

  const double interval = common::secondsFromUtime(health.utime - last_utime_);
  const auto add = [&](const ChannelStatsMap& now, ChannelStatsMap& last, std::int8_t direction) {
    for (const auto& [channel, stats] : now) {
      const ChannelStats& before = last[channel];
      rubble::channel_health_t c;
      c.channel = channel;
      c.direction = direction;
      c.count = stats.count;
      c.dropped = stats.dropped;
      c.errors = stats.errors;
      c.rate_hz = interval > 0.0
                      ? static_cast<float>(static_cast<double>(stats.count - before.count) / interval)
                      : 0.0F;
      c.latency_mean_ms =
          stats.latency_count > 0
              ? static_cast<float>(stats.latency_sum_ms / static_cast<double>(stats.latency_count))
              : std::numeric_limits<float>::quiet_NaN();
      c.latency_max_ms = static_cast<float>(stats.latency_max_ms);
      health.channels.push_back(c);
      if (stats.errors > before.errors) {
        degrade(health, rubble::health_t::LEVEL_DEGRADED,
                fmt::format("{} messages refused on {}: {}", stats.errors - before.errors, channel,
                            stats.last_error));
      }
      if (stats.dropped > before.dropped && direction == rubble::channel_health_t::RECEIVED) {
        degrade(health, rubble::health_t::LEVEL_DEGRADED,
                fmt::format("{} messages of {} dropped: this process is too slow for them",
                            stats.dropped - before.dropped, channel));
      }
    }
    last = now;
  };
  add(bus.published(), last_published_, rubble::channel_health_t::PUBLISHED);
  add(bus.received(), last_received_, rubble::channel_health_t::RECEIVED);
  bus.resetLatency();
  last_utime_ = health.utime;

  if (const std::string channel = bus.conflict(); !channel.empty()) {
    degrade(health, rubble::health_t::LEVEL_ERROR,
            fmt::format(
                "another process publishes {}: stopped publishing it; stop the other one (replaying a log? "
                "`rubble play` feeds sources only), then restart this one",
                channel));
  }
  for (const auto& [name, count] : status.counters) {
    rubble::counter_t counter;
    counter.name = name;
    counter.count = count;
    health.counters.push_back(counter);
  }
  health.nchannels = static_cast<std::int32_t>(health.channels.size());
  health.ncounters = static_cast<std::int32_t>(health.counters.size());
  return health;
}

}  // namespace rubble::lcm_io
