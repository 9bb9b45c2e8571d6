#include "motion/retrace.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace rubble::arena_sim {

namespace {

/// From the planned speed to none, s.
constexpr double kBraking = 0.5;

}  // namespace

Retrace retrace(const Motion& plan, double from, double to) {
  const auto& samples = plan.samples();
  const std::size_t kept = std::min(static_cast<std::size_t>(from / Motion::kStep) + 1, samples.size());
  std::vector<common::Pose3> poses(samples.begin(), samples.begin() + static_cast<std::ptrdiff_t>(kept));
  poses.reserve(samples.size());
  // The plan's time goes on at this pace: 1 as planned, -1 backwards.
  double pace = 1.0;
  double planned = static_cast<double>(kept - 1) * Motion::kStep;
  double end = 0.0;
  while (poses.size() < samples.size()) {
    const double change = Motion::kStep / kBraking;
    const double braking_way = 0.5 * pace * pace * kBraking;
    const bool back = end == 0.0 && (pace > 0.0 || planned - braking_way > to);
    pace = std::clamp(pace + (back ? -change : change), -1.0, 1.0);
    planned += pace * Motion::kStep;
    poses.push_back(plan.at(planned));
    if (!back && end == 0.0 && pace >= 0.0) {
      end = static_cast<double>(poses.size() - 1) * Motion::kStep;
    }
  }
  return {Motion(std::move(poses)), end > 0.0 ? end : plan.duration()};
}

}  // namespace rubble::arena_sim
