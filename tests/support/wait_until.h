#pragma once

#include <chrono>
#include <thread>

namespace rubble::test {

/// Generous, for machines under load and sanitizers; a test that passes never waits that long.
inline constexpr std::chrono::seconds kDeadline{20};

/// Asks until the condition holds or the time is over; returns whether it holds.
template <typename Condition>
bool waitUntil(const Condition& condition, std::chrono::milliseconds timeout = kDeadline) {
  const auto deadline = std::chrono::steady_clock::now() + timeout;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > deadline) {
      return false;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

}  // namespace rubble::test
