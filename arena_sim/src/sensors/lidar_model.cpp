#include "sensors/lidar_model.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "scene/materials.h"

namespace rubble::arena_sim {

namespace {

constexpr double kResolution = 0.001;
constexpr double kPictureReflectivity = 0.6;  // Paper.
constexpr double kFlicker = 0.3;              // Of a weak signal, 1 sigma of its logarithm.
constexpr double kEdge = 0.10;                // m between the rims of a beam: two surfaces.
constexpr double kNoiseRange = 10.0;  // m, the noise grows beyond; it is threefold at three times this.

}  // namespace

void visit(common::ConfigSection& section, LidarModelConfig& config) {
  section.integer("beams", config.beams, "", 2, 10'000, "beams of a scan");
  section.number("field_of_view", config.field_of_view, "rad", 0.1, 6.2832, "first to last beam, about x");
  section.number("rate", config.rate, "Hz", 1.0, 100.0, "scans per second");
  section.number("range_sigma", config.range_sigma, "m", 0.0, 0.5, "noise of a range up to 10 m, 1 sigma");
  section.number("dropout_rate", config.dropout_rate, "", 0.0, 1.0, "share of beams lost for no reason");
  section.number("mixed_share", config.mixed_share, "", 0.0, 1.0,
                 "share of beams on an edge that report a range between its two sides");
  section.number("divergence", config.divergence, "rad", 0.0, 0.05, "width of a beam");
  section.number("weakest_signal", config.weakest_signal, "1/m^2", 0.0, 1.0,
                 "reflectivity x cos(incidence) / range^2 that still returns: 0.001 is 10 % at 10 m");
  section.number("min_range", config.min_range, "m", 0.0, 10.0, "nothing is returned below");
  section.number("max_range", config.max_range, "m", 1.0, 100.0, "nothing is returned beyond");
}

LidarModel::LidarModel(const LidarModelConfig& config, double sweep_time_s, const Scene& scene,
                       const RayTracer& tracer, PoseAt T_world_lidar, std::mt19937_64 random)
    : config_(config),
      sweep_time_s_(sweep_time_s),
      tracer_(tracer),
      T_world_lidar_(std::move(T_world_lidar)),
      random_(random) {
  reflectivity_.reserve(scene.surfaces.size());
  for (const Surface& surface : scene.surfaces) {
    reflectivity_.push_back(surface.appearance.picture ? kPictureReflectivity
                                                       : reflectivityAt905nm(surface.appearance.material));
  }
}

LidarModel::Beam LidarModel::castAt(const common::Pose3& T_world_lidar, double angle) const {
  const Eigen::Vector3d direction =
      T_world_lidar.linear() * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0.0);
  const auto hit = tracer_.cast(T_world_lidar.translation(), direction);
  if (!hit) {
    return {std::numeric_limits<double>::infinity(), 0.0};
  }
  return {hit->distance, reflectivity_[hit->surface] * hit->incidence / (hit->distance * hit->distance)};
}

LidarModel::Beam LidarModel::trueBeam(double seconds, int i) const {
  return castAt(T_world_lidar_(seconds + sweep_time_s_ * i / config_.beams), angleOf(i));
}

double LidarModel::mixedRange(const common::Pose3& T_world_lidar, double angle, double range) {
  const double left = castAt(T_world_lidar, angle + 0.5 * config_.divergence).range;
  const double right = castAt(T_world_lidar, angle - 0.5 * config_.divergence).range;
  if (!std::isfinite(left) || !std::isfinite(right) || std::abs(left - right) < kEdge) {
    return range;
  }
  std::uniform_real_distribution<double> share(0.0, 1.0);
  return share(random_) < config_.mixed_share ? left + share(random_) * (right - left) : range;
}

std::vector<float> LidarModel::measure(double seconds) {
  std::normal_distribution<double> gauss;
  std::bernoulli_distribution dropout(config_.dropout_rate);
  std::vector<float> ranges(static_cast<std::size_t>(config_.beams), std::numeric_limits<float>::quiet_NaN());
  for (int i = 0; i < config_.beams; ++i) {
    const common::Pose3 T_world_lidar = T_world_lidar_(seconds + sweep_time_s_ * i / config_.beams);
    const Beam beam = castAt(T_world_lidar, angleOf(i));
    if (dropout(random_) || beam.signal * std::exp(kFlicker * gauss(random_)) < config_.weakest_signal) {
      continue;
    }
    const double range = mixedRange(T_world_lidar, angleOf(i), beam.range);
    const double sigma = config_.range_sigma * std::max(1.0, range / kNoiseRange);
    const double measured = std::round((range + sigma * gauss(random_)) / kResolution) * kResolution;
    if (measured >= config_.min_range && measured <= config_.max_range) {
      ranges[static_cast<std::size_t>(i)] = static_cast<float>(measured);
    }
  }
  return ranges;
}

}  // namespace rubble::arena_sim
