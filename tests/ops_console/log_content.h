#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "lcm_io/bus.h"
#include "lcm_io/log_file.h"

namespace rubble::ops_console {

/// A message that carries its number as the first of `size` bytes.
inline lcm_io::RawMessage numbered(const std::string& channel, std::uint32_t number, std::size_t size,
                                   common::Utime utime) {
  lcm_io::RawMessage message{channel, utime, lcm_io::Bytes(size)};
  for (std::size_t i = 0; i < 4; ++i) {
    message.data[i] = static_cast<std::uint8_t>(number >> (8 * i));
  }
  return message;
}

inline std::uint32_t numberOf(const lcm_io::Bytes& data) {
  return static_cast<std::uint32_t>(data[0] | data[1] << 8 | data[2] << 16) |
         static_cast<std::uint32_t>(data[3]) << 24;
}

inline std::vector<std::filesystem::path> filesIn(const std::filesystem::path& dir,
                                                  const char* extension = ".lcm") {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(dir)) {
    if (entry.path().extension() == extension) {
      files.push_back(entry.path());
    }
  }
  std::sort(files.begin(), files.end());
  return files;
}

/// All events of the logs in `dir` in order. Event numbers must begin at 0 in every file.
inline std::vector<lcm_io::LogEvent> eventsIn(const std::filesystem::path& dir, bool may_be_cut = false) {
  std::vector<lcm_io::LogEvent> events;
  for (const auto& path : filesIn(dir)) {
    lcm_io::LogReader reader(path);
    std::int64_t number = 0;
    while (auto event = reader.next()) {
      EXPECT_EQ(event->number, number++);
      events.push_back(std::move(*event));
    }
    EXPECT_TRUE(may_be_cut || !reader.truncated()) << path;
  }
  return events;
}

/// Numbers of the messages on `channel`, in order.
inline std::vector<std::uint32_t> numbersOn(const std::string& channel,
                                            const std::vector<lcm_io::LogEvent>& events) {
  std::vector<std::uint32_t> numbers;
  for (const lcm_io::LogEvent& event : events) {
    if (event.channel == channel) {
      numbers.push_back(numberOf(event.data));
    }
  }
  return numbers;
}

/// first, first + 1, ...
inline std::vector<std::uint32_t> countFrom(std::uint32_t first, std::size_t n) {
  std::vector<std::uint32_t> numbers(n);
  for (std::size_t i = 0; i < n; ++i) {
    numbers[i] = first + static_cast<std::uint32_t>(i);
  }
  return numbers;
}

}  // namespace rubble::ops_console
