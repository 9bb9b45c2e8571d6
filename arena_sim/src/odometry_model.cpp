#include "odometry_model.h"

#include <cmath>

namespace rubble::arena_sim {

OdometryModel::OdometryModel(const OdometryModelConfig& config, const Motion& motion, std::uint64_t seed)
    : config_(config),
      motion_(motion),
      random_(randomStream(seed, 3)),
      slip_forward_(config.slip_forward * gauss()),
      slip_turn_(config.slip_turn * gauss()) {}

common::Pose2 OdometryModel::next() {
  if (reports_++ == 0) {
    return T_odom_body_;
  }
  const common::Pose2 before = motion_.at((reports_ - 2) / config_.rate);
  const common::Pose2 now = motion_.at((reports_ - 1) / config_.rate);
  const double turn = now.yaw - before.yaw;
  const double middle_yaw = before.yaw + 0.5 * turn;
  const double forward =
      (now.x - before.x) * std::cos(middle_yaw) + (now.y - before.y) * std::sin(middle_yaw);

  const double keep = std::exp(-1.0 / (config_.rate * config_.slip_memory));
  const double fresh = std::sqrt(1.0 - keep * keep);
  slip_forward_ = keep * slip_forward_ + fresh * config_.slip_forward * gauss();
  slip_turn_ = keep * slip_turn_ + fresh * config_.slip_turn * gauss();
  const double told_forward = forward * (1.0 + slip_forward_);
  const double told_turn =
      turn * (1.0 + slip_turn_) + config_.heading_drift * std::sqrt(std::abs(forward)) * gauss();

  const double direction = T_odom_body_.yaw + 0.5 * told_turn;
  T_odom_body_ = {T_odom_body_.x + told_forward * std::cos(direction),
                  T_odom_body_.y + told_forward * std::sin(direction),
                  common::wrapAngle(T_odom_body_.yaw + told_turn)};
  return T_odom_body_;
}

}  // namespace rubble::arena_sim
