#pragma once

#include <cstdint>
#include <random>

#include "common/geometry.h"
#include "motion.h"

namespace rubble::arena_sim {

/// Units in visit() (arena_sim_config.cpp).
struct OdometryModelConfig {
  double rate = 50.0;
  double slip_forward = 0.03;
  double slip_turn = 0.08;
  double slip_memory = 2.0;
  double heading_drift = 0.02;
};

/// Track odometry: distances and turns as the tracks tell them, wrong by a slip that changes slowly
/// (first-order Gauss-Markov) and by a heading that wanders with the way.
class OdometryModel {
 public:
  OdometryModel(const OdometryModelConfig& config, const Motion& motion, std::uint64_t seed);

  /// T_odom_body at the next report, 1 / rate after the last; the first is the identity at 0 s.
  common::Pose2 next();

 private:
  double gauss() { return std::normal_distribution<double>()(random_); }

  const OdometryModelConfig config_;
  const Motion& motion_;
  std::mt19937_64 random_;
  int reports_ = 0;
  double slip_forward_;
  double slip_turn_;
  common::Pose2 T_odom_body_;
};

}  // namespace rubble::arena_sim
