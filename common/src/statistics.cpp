#include "common/statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace rubble::common {

Statistics statisticsOf(std::vector<double> values) {
  if (values.empty()) {
    constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
    return {kNaN, kNaN, kNaN, kNaN, kNaN};
  }
  std::sort(values.begin(), values.end());
  const std::size_t size = values.size();
  const auto n = static_cast<double>(size);
  double sum = 0.0;
  double sum_squares = 0.0;
  for (const double value : values) {
    sum += value;
    sum_squares += value * value;
  }
  Statistics statistics;
  statistics.mean = sum / n;
  statistics.median = 0.5 * (values[(size - 1) / 2] + values[size / 2]);
  statistics.rmse = std::sqrt(sum_squares / n);
  double deviation = 0.0;
  for (const double value : values) {
    deviation += (value - statistics.mean) * (value - statistics.mean);
  }
  statistics.std = std::sqrt(deviation / n);
  statistics.max = values.back();
  return statistics;
}

double quantileOf(std::vector<double> values, double share) {
  if (values.empty()) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  std::sort(values.begin(), values.end());
  const double place = share * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, values.size() - 1);
  return std::lerp(values[below], values[above], place - static_cast<double>(below));
}

}  // namespace rubble::common
