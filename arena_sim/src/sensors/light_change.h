#pragma once

#include <array>
#include <cstdint>

#include "scene/scene.h"

namespace rubble::arena_sim {

/// How the lamps' brightness goes on over time: it drifts, and now and then it jumps.
class LightChange {
 public:
  /// `strength`: about the largest change, as a share.
  LightChange(double strength, std::uint64_t seed) : strength_(strength), seed_(seed) {}

  /// Factor on the light of lamp group `group`.
  double brightness(int group, double seconds) const;

 private:
  double uniform(int group, std::int64_t stretch, unsigned purpose) const;

  const double strength_;
  const std::uint64_t seed_;
};

}  // namespace rubble::arena_sim
