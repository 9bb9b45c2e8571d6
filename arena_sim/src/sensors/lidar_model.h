#pragma once

#include <optional>
#include <random>
#include <vector>

#include "common/config.h"
#include "scene/ray_tracer.h"
#include "scene/scene.h"
#include "sensors/pose_at.h"

namespace rubble::arena_sim {

/// Units in visit(). The defaults are a UTM-30LX.
struct LidarModelConfig {
  int beams = 1081;
  double field_of_view = 4.71238898038469;  // 270 degrees
  double rate = 40.0;
  double range_sigma = 0.01;
  double dropout_rate = 0.002;
  double mixed_share = 0.4;
  double divergence = 0.0044;
  double weakest_signal = 0.001;
  double min_range = 0.1;
  double max_range = 30.0;

  double firstAngle() const { return -0.5 * field_of_view; }
  double angleStep() const { return field_of_view / (beams - 1); }
};

void visit(common::ConfigSection& section, LidarModelConfig& config);

/// A planar LiDAR in the scene: beam i of n is measured at i / n of the sweep, from wherever the plate is
/// then. A weak return (dark, far or glancing: reflectivity cos / range^2 below a limit that flickers) drops
/// out; a beam whose two rims see different surfaces may report a range between them.
class LidarModel {
 public:
  /// T_world_lidar is asked for during sweeps. Scene and tracer must outlive this.
  LidarModel(const LidarModelConfig& config, double sweep_time_s, const Scene& scene, const RayTracer& tracer,
             PoseAt T_world_lidar, std::mt19937_64 random);

  struct Beam {
    double range = 0.0;   // m, of its middle; infinity where nothing is.
    double signal = 0.0;  // reflectivity cos / range^2
  };

  /// Beam i of the sweep that begins at `seconds`, as it is.
  Beam trueBeam(double seconds, int i) const;

  /// What the sensor says of the sweep: noisy, in whole millimetres, NaN where nothing returned. Draws the
  /// next random numbers.
  std::vector<float> measure(double seconds);

 private:
  double angleOf(int i) const { return config_.firstAngle() + i * config_.angleStep(); }
  Beam castAt(const common::Pose3& T_world_lidar, double angle) const;
  double mixedRange(const common::Pose3& T_world_lidar, double angle, double range);

  const LidarModelConfig config_;
  const double sweep_time_s_;
  const RayTracer& tracer_;
  const PoseAt T_world_lidar_;
  std::vector<double> reflectivity_;  // Of each surface.
  std::mt19937_64 random_;
};

}  // namespace rubble::arena_sim
