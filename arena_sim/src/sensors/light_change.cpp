#include "sensors/light_change.h"

#include <cmath>

#include "sensors/ray_table.h"

namespace rubble::arena_sim {

namespace {

constexpr double kDriftPeriod = 15.0;  // s between the points that the drift passes.
constexpr double kStepPeriod = 40.0;   // s; one jump in each, anywhere.

}  // namespace

double LightChange::brightness(int group, double seconds) const {
  const double drift_time = seconds / kDriftPeriod;
  const auto point = static_cast<std::int64_t>(std::floor(drift_time));
  const double share = drift_time - static_cast<double>(point);
  const double smooth = share * share * (3.0 - 2.0 * share);
  const double drift = std::lerp(uniform(group, point, 0), uniform(group, point + 1, 0), smooth);

  const double step_time = seconds / kStepPeriod;
  const auto stretch = static_cast<std::int64_t>(std::floor(step_time));
  const double jump = 0.5 * (1.0 + uniform(group, stretch, 1));
  const bool jumped = step_time - static_cast<double>(stretch) >= jump;
  const double step = uniform(group, jumped ? stretch : stretch - 1, 2);
  return std::exp(0.5 * strength_ * (drift + step));
}

/// In [-1, 1).
double LightChange::uniform(int group, std::int64_t stretch, unsigned purpose) const {
  const auto place =
      static_cast<std::uint64_t>(stretch) * 8U + static_cast<std::uint64_t>(group) * 4U + purpose;
  return static_cast<double>(hashOf(hashOf(seed_) + place) >> 11U) * 0x1p-52 - 1.0;
}

}  // namespace rubble::arena_sim
