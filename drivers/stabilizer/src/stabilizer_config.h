#pragma once

#include <string>

#include "common/config.h"
#include "device/stabilizer_driver.h"

namespace rubble::stabilizer {

/// One servo; units in visit().
struct AxisConfig {
  int node = 1;
  int counts_per_turn = 4096;
  double gear = 50.0;
  bool reversed = false;
  double zero_offset = 0.0;
  double lowest = -0.35;
  double highest = 0.35;
  double rate = 2.5;
};

/// Section `stabilizer`.
struct StabilizerConfig {
  std::string interface = "can0";
  std::string mode = "csp";
  int cycle_ms = 10;
  int heartbeat_ms = 100;
  double heartbeat_timeout = 0.35;
  double acceleration = 50.0;
  double following_error = 0.15;
  int fault_resets = 5;
  double first_pause = 0.2;
  double longest_pause = 5.0;
  AxisConfig roll;
  AxisConfig pitch{.node = 2};
};

void visit(common::ConfigSection& section, AxisConfig& config);
/// Throws common::Error for limits in the wrong order, equal nodes and angles beyond 32 bits of increments.
void visit(common::ConfigSection& section, StabilizerConfig& config);

StabilizerDriver::Options driverOptions(const StabilizerConfig& config);

}  // namespace rubble::stabilizer
