#pragma once

#include <filesystem>
#include <vector>

#include "common/statistics.h"
#include "common/trajectory.h"

namespace rubble::tools {

/// Pose of the robot at utime_2 seen from where it was at utime_1 (Kuemmerle et al. 2009).
struct Relation {
  common::Utime utime_1 = 0;
  common::Utime utime_2 = 0;
  common::Pose3 T_1_2 = common::Pose3::Identity();
};

/// Lines `t1 t2 x y z roll pitch yaw` (s, m, rad). Throws Error naming file and line.
std::vector<Relation> readRelations(const std::filesystem::path& path);

struct RelationsResult {
  int matched = 0;  // relations whose two stamps both have a pose
  int total = 0;
  common::Statistics translation_m;  // |translation| of inverse(reference) * estimate
  common::Statistics rotation_deg;   // its angle
};

/// Takes the estimate's poses nearest to the stamps, at most `max_difference` seconds away. Throws Error when
/// no relation is matched.
RelationsResult evaluateRelations(const common::Trajectory& estimate, const std::vector<Relation>& relations,
                                  double max_difference);

}  // namespace rubble::tools
