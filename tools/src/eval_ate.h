#pragma once

#include "common/statistics.h"
#include "common/trajectory.h"

namespace rubble::tools {

/// Share of the truth's poses near which (3/4 of the estimate's usual interval, its 10 % quantile) there is
/// an estimate. With truth at the pictures' stamps: the share of pictures that got a pose.
double trackedShare(const common::Trajectory& estimate, const common::Trajectory& truth);

/// How the estimate may be moved onto the truth before the two are compared.
enum class Alignment {
  kSim3,   // rotation, translation and scale that fit best (Umeyama 1991)
  kSe3,    // rotation and translation that fit best
  kStart,  // x, y, z and yaw at the first common stamp; roll and pitch stay the estimate's own
};

struct AteResult {
  int poses = 0;    // of the estimate
  int matched = 0;  // of these, with truth at their time
  int truth_poses = 0;
  double tracked_share = 0.0;  // trackedShare()
  double scale = 1.0;          // of the alignment
  common::Statistics translation_m;
  double z_rmse_m = 0.0;
  double attitude_rmse_deg = 0.0;  // angle between the two verticals: roll and pitch without yaw
  double rotation_rmse_deg = 0.0;
};

/// Absolute trajectory error of aligned T_world_b against truth. Truth is taken at the estimate's stamp:
/// interpolated between neighbours at most `max_gap` (seconds) apart, or as it is within 1 ms. Throws Error
/// for less than one (kStart) or three common stamps.
AteResult evaluateAte(const common::Trajectory& estimate, const common::Trajectory& truth,
                      Alignment alignment, double max_gap);

}  // namespace rubble::tools
