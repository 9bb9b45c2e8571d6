#include "sensors/odometry_model.h"

#include <cmath>
#include <utility>

namespace rubble::arena_sim {

void visit(common::ConfigSection& section, OdometryModelConfig& config) {
  section.number("rate", config.rate, "Hz", 1.0, 200.0, "messages per second");
  section.number("slip_forward", config.slip_forward, "", 0.0, 0.5, "relative error of distances, 1 sigma");
  section.number("slip_turn", config.slip_turn, "", 0.0, 0.5, "relative error of turns, 1 sigma");
  section.number("slip_memory", config.slip_memory, "s", 0.01, 100.0, "time over which slip changes");
  section.number("slip_slope", config.slip_slope, "", 0.0, 1.0,
                 "share of track lost per sine of the slope: more track than way uphill, less downhill");
  section.number("heading_drift", config.heading_drift, "rad/sqrt(m)", 0.0, 0.5,
                 "heading error after one metre, 1 sigma; grows with the root of the way");
}

OdometryModel::OdometryModel(const OdometryModelConfig& config, PoseAt T_world_body, std::mt19937_64 random)
    : config_(config),
      T_world_body_(std::move(T_world_body)),
      random_(random),
      slip_forward_(config.slip_forward * gauss()),
      slip_turn_(config.slip_turn * gauss()) {}

common::Pose2 OdometryModel::next() {
  if (reports_++ == 0) {
    return T_odom_body_;
  }
  const common::Pose3 before = T_world_body_((reports_ - 2) / config_.rate);
  const common::Pose3 step = before.inverse() * T_world_body_((reports_ - 1) / config_.rate);
  const double turn = std::atan2(step.linear()(1, 0), step.linear()(0, 0));
  const double forward =
      step.translation().x() * std::cos(0.5 * turn) + step.translation().y() * std::sin(0.5 * turn);
  const double climb = before.linear()(2, 0);  // Sine of the slope ahead.

  const double keep = std::exp(-1.0 / (config_.rate * config_.slip_memory));
  const double fresh = std::sqrt(1.0 - keep * keep);
  slip_forward_ = keep * slip_forward_ + fresh * config_.slip_forward * gauss();
  slip_turn_ = keep * slip_turn_ + fresh * config_.slip_turn * gauss();
  const double told_forward = forward * (1.0 + slip_forward_ + config_.slip_slope * climb);
  const double told_turn =
      turn * (1.0 + slip_turn_) + config_.heading_drift * std::sqrt(std::abs(forward)) * gauss();

  const double direction = T_odom_body_.yaw + 0.5 * told_turn;
  T_odom_body_ = {T_odom_body_.x + told_forward * std::cos(direction),
                  T_odom_body_.y + told_forward * std::sin(direction),
                  common::wrapAngle(T_odom_body_.yaw + told_turn)};
  return T_odom_body_;
}

}  // namespace rubble::arena_sim
