#include "loss_counter.h"

#include <algorithm>

#include "lcm_io/channels.h"

namespace rubble::ops_console {

void LossCounter::Comparison::add(std::int64_t difference) {
  confirmed = std::max(confirmed, std::min(last, difference));
  smallest = std::min(smallest, difference);
  last = difference;
}

std::int64_t LossCounter::report(const PublisherReport& report) {
  Publisher& publisher = publishers_[report.process];
  if (publisher.pid != report.pid || publisher.start_utime != report.start_utime) {
    restart(publisher, report);
  }
  for (const auto& [channel, published] : report.published) {
    // A report does not count itself yet, hence the comparison before the increment below.
    const std::int64_t received =
        channel == lcm_io::channel::kHealth ? publisher.health_received : received_[channel];
    publisher.channels[channel].add(published - received);
  }
  ++publisher.health_received;

  const auto total = [](const std::map<std::string, std::int64_t>& lost) {
    std::int64_t sum = 0;
    for (const auto& [channel, count] : lost) {
      sum += count;
    }
    return sum;
  };
  const std::int64_t before = total(lost_);
  lost_ = sumUp();
  return std::max<std::int64_t>(0, total(lost_) - before);
}

void LossCounter::restart(Publisher& publisher, const PublisherReport& report) {
  for (const auto& [channel, comparison] : publisher.channels) {
    lost_before_[channel] += comparison.lost();
  }
  publisher.channels.clear();
  publisher.pid = report.pid;
  publisher.start_utime = report.start_utime;
}

std::map<std::string, std::int64_t> LossCounter::sumUp() const {
  std::map<std::string, std::int64_t> lost = lost_before_;
  std::map<std::string, int> publishers;
  for (const auto& [process, publisher] : publishers_) {
    for (const auto& [channel, comparison] : publisher.channels) {
      lost[channel] += comparison.lost();
      ++publishers[channel];
    }
  }
  std::erase_if(lost, [&](const auto& entry) {
    return entry.second == 0 || (entry.first != lcm_io::channel::kHealth && publishers[entry.first] > 1);
  });
  return lost;
}

}  // namespace rubble::ops_console
