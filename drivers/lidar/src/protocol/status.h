#pragma once

#include <string>
#include <string_view>

namespace rubble::lidar {

/// What the two characters of a status mean for a driver (SCIP 2.0 sections 8 and 9).
enum class StatusKind {
  kDone,         // 00
  kScan,         // 99: a scan follows
  kVerifying,    // 21 .. 49: it stopped to check an error of its own; 98: found well again
  kMalfunction,  // 50 .. 97, and 0L, 0M of newer models
  kRefused,      // anything else; the meaning depends on the command
};

StatusKind kindOf(std::string_view status);

/// What the sensor says, in words, e.g. `status 0E (undefined command)`; `command` is the echo.
std::string describeStatus(std::string_view command, std::string_view status);

}  // namespace rubble::lidar
