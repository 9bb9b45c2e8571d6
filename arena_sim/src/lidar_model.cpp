#include "lidar_model.h"

#include <cmath>
#include <limits>

namespace rubble::arena_sim {

LidarModel::LidarModel(const LidarModelConfig& config, const RayCaster& caster, const Motion& motion,
                       const common::Pose2& T_body_lidar, double sweep_time_s, std::uint64_t seed)
    : config_(config),
      caster_(caster),
      motion_(motion),
      T_body_lidar_(T_body_lidar),
      sweep_time_s_(sweep_time_s),
      random_(randomStream(seed, 2)) {}

common::Pose2 LidarModel::pose(double seconds) const {
  const common::Pose2 T_world_body = motion_.at(seconds);
  const Eigen::Vector2d p = T_world_body * T_body_lidar_.translation();
  return {p.x(), p.y(), T_world_body.yaw + T_body_lidar_.yaw};
}

std::vector<double> LidarModel::trueRanges(double seconds) const {
  std::vector<double> ranges(static_cast<std::size_t>(config_.beams));
  for (int i = 0; i < config_.beams; ++i) {
    const common::Pose2 T_world_lidar = pose(seconds + sweep_time_s_ * i / config_.beams);
    const double angle = T_world_lidar.yaw + config_.firstAngle() + i * config_.angleStep();
    ranges[static_cast<std::size_t>(i)] =
        caster_.cast(T_world_lidar.translation(), {std::cos(angle), std::sin(angle)});
  }
  return ranges;
}

std::vector<float> LidarModel::measure(double seconds) {
  constexpr double kResolution = 0.001;
  std::normal_distribution<double> noise(0.0, config_.range_sigma);
  std::bernoulli_distribution dropout(config_.dropout_rate);
  std::vector<float> ranges;
  ranges.reserve(static_cast<std::size_t>(config_.beams));
  for (const double range : trueRanges(seconds)) {
    const double measured = std::round((range + noise(random_)) / kResolution) * kResolution;
    const bool returned = !dropout(random_) && measured >= config_.min_range && measured <= config_.max_range;
    ranges.push_back(returned ? static_cast<float>(measured) : std::numeric_limits<float>::quiet_NaN());
  }
  return ranges;
}

}  // namespace rubble::arena_sim
