#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "lcm_io/codec.h"
#include "lcm_io/log_file.h"

namespace rubble::test {

/// All events of a log.
inline std::vector<lcm_io::LogEvent> eventsOf(const std::filesystem::path& log) {
  lcm_io::LogReader reader(log);
  std::vector<lcm_io::LogEvent> events;
  while (auto event = reader.next()) {
    events.push_back(std::move(*event));
  }
  return events;
}

/// The messages of one channel.
template <typename Message>
std::vector<Message> messagesOf(const std::filesystem::path& log, const std::string& channel) {
  std::vector<Message> messages;
  for (const lcm_io::LogEvent& event : eventsOf(log)) {
    if (event.channel == channel) {
      messages.push_back(lcm_io::decode<Message>(event.data));
    }
  }
  return messages;
}

}  // namespace rubble::test
