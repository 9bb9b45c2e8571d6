#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <string>

#include "common/time.h"

namespace rubble::ops_console {

/// What one process says it has published since its start.
struct PublisherReport {
  std::string process;
  /// A change of either is a restart.
  std::int32_t pid = 0;
  common::Utime start_utime = 0;
  std::map<std::string, std::int64_t> published;
};

/// Counts the messages that were published but never received here: published minus received has grown since
/// both were first seen. A message that a report has overtaken is not lost: what two reports in a row miss
/// is. A restart of the publisher starts a new comparison, what was found lost before stays. HEALTH is
/// compared per process; of another channel that several processes publish nothing can be said.
class LossCounter {
 public:
  /// A message of any channel but HEALTH.
  void received(const std::string& channel) { ++received_[channel]; }

  /// A HEALTH message, which counts as received. Returns how many losses it brought to light.
  std::int64_t report(const PublisherReport& report);

  /// Messages lost since the start, of every channel that lost any.
  const std::map<std::string, std::int64_t>& lost() const { return lost_; }

 private:
  /// Of published minus received on one channel, over the reports of one publisher.
  struct Comparison {
    std::int64_t last = std::numeric_limits<std::int64_t>::min();
    std::int64_t smallest = std::numeric_limits<std::int64_t>::max();
    /// The largest that two reports in a row have reached.
    std::int64_t confirmed = std::numeric_limits<std::int64_t>::min();

    void add(std::int64_t difference);
    std::int64_t lost() const { return confirmed > smallest ? confirmed - smallest : 0; }
  };

  struct Publisher {
    std::int32_t pid = 0;
    common::Utime start_utime = 0;
    std::int64_t health_received = 0;
    std::map<std::string, Comparison> channels;
  };

  std::map<std::string, std::int64_t> sumUp() const;
  void restart(Publisher& publisher, const PublisherReport& report);

  std::map<std::string, std::int64_t> received_;
  std::map<std::string, Publisher> publishers_;
  /// By channel: found lost by comparisons that a restart has ended.
  std::map<std::string, std::int64_t> lost_before_;
  std::map<std::string, std::int64_t> lost_;
};

}  // namespace rubble::ops_console
