#include "lcm_io/bus.h"

#include <algorithm>

#include "common/error.h"

namespace rubble::lcm_io {

void Bus::subscribeRaw(const std::string& channel, RawHandler handler) {
  const bool inserted = handlers_.emplace(channel, std::move(handler)).second;
  RUBBLE_CHECK(inserted);
  received_[channel];
  attach(channel);
}

void Bus::subscribeAll(RawHandler handler) {
  RUBBLE_CHECK(!all_handler_);
  all_handler_ = std::move(handler);
  attach(kEveryChannel);
}

void Bus::publishRaw(const std::string& channel, ByteView data) {
  if (send(channel, data)) {
    ++published_[channel].count;
  } else {
    ++published_[channel].dropped;
  }
}

void Bus::deliver(const RawMessage& message) {
  const auto found = handlers_.find(message.channel);
  const RawHandler& handler = found != handlers_.end() ? found->second : all_handler_;
  if (!handler) {
    return;
  }
  ChannelStats& stats = received_[message.channel];
  ++stats.count;
  try {
    handler(message);
  } catch (const common::Error& e) {
    refuse(message.channel, e.what());
  }
}

void Bus::refuse(const std::string& channel, const std::string& why) {
  ChannelStats& stats = received_[channel];
  ++stats.errors;
  stats.last_error = why;
}

void Bus::noteLatency(const std::string& channel, common::Utime utime) {
  ChannelStats& stats = received_[channel];
  const double latency_ms = static_cast<double>(now() - utime) * 1e-3;
  ++stats.latency_count;
  stats.latency_sum_ms += latency_ms;
  stats.latency_max_ms = std::max(stats.latency_max_ms, latency_ms);
}

void Bus::resetLatency() {
  for (auto& [channel, stats] : received_) {
    stats.latency_count = 0;
    stats.latency_sum_ms = 0.0;
    stats.latency_max_ms = 0.0;
  }
}

}  // namespace rubble::lcm_io
