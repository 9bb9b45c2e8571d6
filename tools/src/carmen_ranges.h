#pragma once

#include <optional>
#include <vector>

#include "carmen_log.h"

namespace rubble::tools {

/// Makes every range infinite that is no hit but the sensor's "nothing seen": NaN, at or above the maximum
/// that the line or else the log's parameter (0: unknown) states, 80 m for a SICK (its codes for no return
/// lie between 81.83 and 81.92 m) and where nothing is stated. Returns the value that turned out to be the
/// sensor's limit without being stated: the log's largest range, a whole number of tens of metres, and so
/// frequent that no wall explains it (aces: 50.00 m in 11139 beams, 1 between 49 and 49.5).
std::optional<float> markNoReturns(std::vector<CarmenScan>& scans, double param_max_range);

}  // namespace rubble::tools
