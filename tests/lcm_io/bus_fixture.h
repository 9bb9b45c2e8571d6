#pragma once

#include <gtest/gtest.h>

#include <string>

#include "lcm_io/lcm_bus.h"
#include "support/lcm_url.h"
#include "support/wait_until.h"

namespace rubble::lcm_io {

/// Handles messages until the condition holds; false when the time is over.
template <typename Condition>
bool dispatchUntil(Bus& bus, const Condition& condition,
                   std::chrono::milliseconds timeout = test::kDeadline) {
  const auto deadline = std::chrono::steady_clock::now() + timeout;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > deadline) {
      return false;
    }
    bus.dispatch(std::chrono::milliseconds(20));
  }
  return true;
}

/// Several ends of one live bus on a port of its own.
class LiveBusTest : public testing::Test {
 protected:
  void SetUp() override { RUBBLE_NEEDS_MULTICAST(); }

  const std::string url_ = test::privateLcmUrl();
};

}  // namespace rubble::lcm_io
