#pragma once

#include <vector>

#include "common/geometry.h"

namespace rubble::arena_sim {

/// T_world_body over time, seconds from 0: samples kStep apart, in between linear in position and along the
/// great arc in rotation, which makes it the exact truth.
class Motion {
 public:
  static constexpr double kStep = 0.005;

  explicit Motion(std::vector<common::Pose3> samples);

  /// Standing at the ends: any time may be asked for.
  common::Pose3 at(double seconds) const;
  double duration() const;
  const std::vector<common::Pose3>& samples() const { return samples_; }
  /// Metres of way, slopes as long as they are.
  double pathLength() const;

 private:
  std::vector<common::Pose3> samples_;
};

}  // namespace rubble::arena_sim
