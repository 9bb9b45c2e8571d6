#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "common/geometry.h"
#include "motion.h"
#include "ray_caster.h"

namespace rubble::arena_sim {

/// Units in visit() (arena_sim_config.cpp). The defaults are a UTM-30LX.
struct LidarModelConfig {
  int beams = 1081;
  double field_of_view = 4.71238898038469;  // 270 degrees
  double rate = 40.0;
  double range_sigma = 0.01;
  double dropout_rate = 0.005;
  double min_range = 0.1;
  double max_range = 30.0;

  double firstAngle() const { return -0.5 * field_of_view; }
  double angleStep() const { return field_of_view / (beams - 1); }
};

/// A level planar LiDAR on the moving robot: beam i of n is measured at i / n of the sweep.
class LidarModel {
 public:
  LidarModel(const LidarModelConfig& config, const RayCaster& caster, const Motion& motion,
             const common::Pose2& T_body_lidar, double sweep_time_s, std::uint64_t seed);

  /// T_world_lidar in the plane of the scan; the yaw runs on over full turns.
  common::Pose2 pose(double seconds) const;

  /// The true ranges (m) of the sweep that begins at `seconds`; infinity where there is no wall.
  std::vector<double> trueRanges(double seconds) const;

  /// What the sensor says of it: noisy, in whole millimetres, NaN where nothing returned. Draws the next
  /// random numbers.
  std::vector<float> measure(double seconds);

 private:
  const LidarModelConfig config_;
  const RayCaster& caster_;
  const Motion& motion_;
  const common::Pose2 T_body_lidar_;
  const double sweep_time_s_;
  std::mt19937_64 random_;
};

}  // namespace rubble::arena_sim
