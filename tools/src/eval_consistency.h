#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <map>
#include <vector>

#include "common/trajectory.h"

namespace rubble::tools {

/// A fused pose with what it was said to be good to.
struct UncertainPose {
  common::StampedPose pose;  ///< T_world_body
  char state = 'H';          ///< control state
  /// Of (position in world, rotation vector in world, applied from the left): m, rad.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Identity();
};

/// trajectory_fused.tum and covariance.csv of the results of a replay. Throws common::Error naming file and
/// line.
std::vector<UncertainPose> readUncertainPoses(const std::filesystem::path& results);

/// Shares of the poses whose squared error, by its covariance, is inside the 95 % bound of chi squared
/// (Bar-Shalom, Li, Kirubarajan 2001, section 5.4).
struct Consistency {
  int poses = 0;
  double xy = 0.0;
  double z = 0.0;
  double attitude = 0.0;  ///< all three angles together
};

/// By control state. Truth is taken at the poses' own stamps; what has none, or comes before `settled` (s
/// after the first pose), is left out.
std::map<char, Consistency> evaluateConsistency(const std::vector<UncertainPose>& poses,
                                                const common::Trajectory& truth, double settled);

}  // namespace rubble::tools
