#pragma once

#include <gtest/gtest.h>

#include <string>

namespace rubble::test {

/// LCM's group on a port of this test process's own, never leaving the host. Every call is another port.
std::string privateLcmUrl();

/// Why LCM has no multicast here; empty where it has.
std::string missingMulticast();

}  // namespace rubble::test

/// Skips the test on a host without a multicast route.
#define RUBBLE_NEEDS_MULTICAST()                                                          \
  if (const std::string missing = ::rubble::test::missingMulticast(); !missing.empty()) { \
    GTEST_SKIP() << "tests of the live bus are skipped: " << missing;                     \
  }
