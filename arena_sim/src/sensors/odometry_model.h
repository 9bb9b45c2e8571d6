#pragma once

#include <random>

#include "common/config.h"
#include "common/geometry.h"
#include "sensors/pose_at.h"

namespace rubble::arena_sim {

/// Units in visit().
struct OdometryModelConfig {
  double rate = 50.0;
  double slip_forward = 0.03;
  double slip_turn = 0.08;
  double slip_memory = 2.0;
  double slip_slope = 0.15;
  double heading_drift = 0.02;
};

void visit(common::ConfigSection& section, OdometryModelConfig& config);

/// Track odometry: distances along the ground and turns as the tracks tell them, as if the ground were flat;
/// wrong by a slip that changes slowly (first-order Gauss-Markov), by more track than way on a climb, and by
/// a heading that wanders with the way.
class OdometryModel {
 public:
  OdometryModel(const OdometryModelConfig& config, PoseAt T_world_body, std::mt19937_64 random);

  /// T_odom_body at the next report, 1 / rate after the last; the first is the identity at 0 s.
  common::Pose2 next();

 private:
  double gauss() { return std::normal_distribution<double>()(random_); }

  const OdometryModelConfig config_;
  const PoseAt T_world_body_;
  std::mt19937_64 random_;
  int reports_ = 0;
  double slip_forward_;
  double slip_turn_;
  common::Pose2 T_odom_body_;
};

}  // namespace rubble::arena_sim
