#pragma once

#include "alignment.h"
#include "common/config.h"
#include "joint/joint_window.h"
#include "marks/object_marks.h"
#include "plane_state.h"

namespace rubble::fusion {

/// Section `fusion`.
struct FusionConfig {
  PlaneStateConfig plane;
  AlignmentConfig alignment;
  JointConfig joint;
  double window = 10.0;           ///< m of way in H that the alignment looks back
  double min_way = 0.3;           ///< m, before a first scale
  double max_scale_sigma = 0.05;  ///< relative; above it the scale is unknown
  double firm_way = 3.0;          ///< m, until which a new scale is not held against the LiDAR
  double lidar_gain = 0.03;
  double alignment_gain = 0.3;
  double servo_range = 0.35;  ///< rad
  double servo_lead = 0.03;   ///< s
  double checkpoint_period = 1.0;
  double restore_within = 120.0;
  MarksConfig marks;
};

void visit(common::ConfigSection& section, FusionConfig& config);

}  // namespace rubble::fusion
