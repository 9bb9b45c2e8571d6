#pragma once

#include <vector>

namespace rubble::common {

/// Of at least one value; NaN without any.
struct Statistics {
  double mean = 0.0;
  double median = 0.0;
  double rmse = 0.0;  // root of the mean square
  double std = 0.0;   // about the mean, divided by n
  double max = 0.0;
};

Statistics statisticsOf(std::vector<double> values);

/// What this share of the values (0 .. 1) does not exceed, interpolated; NaN without any.
double quantileOf(std::vector<double> values, double share);

}  // namespace rubble::common
