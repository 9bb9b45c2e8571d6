#pragma once

#include <string>

#include "common/config.h"

namespace rubble::ops_console {

/// Section `ops_console`.
struct OpsConsoleConfig {
  std::string log_dir = "/var/log/rubble";
  int quota_mb = 20'000;
  int rotate_mb = 500;
  int rotate_s = 600;
  int queue_mb = 64;
};

/// Throws common::Error when a single log could exceed half the quota.
void visit(common::ConfigSection& section, OpsConsoleConfig& config);

}  // namespace rubble::ops_console
