#include "carmen_ranges.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace rubble::tools {

namespace {

constexpr double kLongestSick = 82.0;
constexpr int kClippedBeams = 100;
constexpr float kClipStep = 10.0F;
constexpr float kInfinity = std::numeric_limits<float>::infinity();

double noReturnFrom(double stated_max) {
  if (stated_max <= 0.0) {
    return kCarmenNoReturn;
  }
  return stated_max > kLongestSick ? stated_max : std::min(stated_max, kCarmenNoReturn);
}

std::optional<float> findClippedRange(const std::vector<CarmenScan>& scans) {
  float largest = 0.0F;
  int count = 0;
  for (const CarmenScan& scan : scans) {
    for (const float range : scan.ranges) {
      if (std::isfinite(range) && range > largest) {
        largest = range;
        count = 0;
      }
      count += range == largest ? 1 : 0;
    }
  }
  const bool round = largest > 0.0F && std::fmod(largest, kClipStep) == 0.0F;
  return round && count >= kClippedBeams ? std::optional(largest) : std::nullopt;
}

}  // namespace

std::optional<float> markNoReturns(std::vector<CarmenScan>& scans, double param_max_range) {
  for (CarmenScan& scan : scans) {
    const double limit = noReturnFrom(scan.max_range > 0.0 ? scan.max_range : param_max_range);
    for (float& range : scan.ranges) {
      if (!(range < static_cast<float>(limit))) {
        range = kInfinity;
      }
    }
  }
  const std::optional<float> clipped = findClippedRange(scans);
  if (clipped) {
    for (CarmenScan& scan : scans) {
      std::replace(scan.ranges.begin(), scan.ranges.end(), *clipped, kInfinity);
    }
  }
  return clipped;
}

}  // namespace rubble::tools
