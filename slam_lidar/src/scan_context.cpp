#include "scan_context.h"

#include <cmath>
#include <utility>

#include "common/error.h"

namespace rubble::slam_lidar {

using common::Pose3;
using common::Utime;

namespace {

common::Pose2 planar(const Pose3& T) {
  return {T.translation().x(), T.translation().y(), common::rpyFromRotation(T.linear()).yaw};
}

}  // namespace

void ScanContext::addPlate(Utime utime, double roll, double pitch) {
  if (!std::isfinite(roll) || !std::isfinite(pitch)) {
    throw common::Error("plate angles that are not finite");
  }
  plate_.add(utime, {roll, pitch});
}

void ScanContext::addBody(Utime utime, const Pose3& T_world_body) { body_.add(utime, T_world_body); }

void ScanContext::addOdometry(Utime utime, const Pose3& T_odom_body) { odometry_.add(utime, T_odom_body); }

bool ScanContext::complete(Utime first, Utime last) const {
  return (plate_.silent(last) || plate_.covers(last)) && (body_.silent(last) || body_.covers(last)) &&
         (odometry_.silent(first) || odometry_.covers(first));
}

Pose3 ScanContext::T_body_lidar(Utime utime) const {
  const auto plate = plate_.at(utime);
  const Eigen::Vector2d angles =
      plate ? plate->value : (plate_.empty() ? Eigen::Vector2d::Zero() : plate_.newest());
  return robot_.T_body_plate(angles.x(), angles.y()) * robot_.lidar.pose();
}

ScanContext::Tilt ScanContext::tiltAt(Utime utime) const {
  const auto body = body_.at(utime);
  const auto plate = plate_.at(utime);
  const auto guessed = [](const auto& history, const auto& sample) {
    return !history.empty() && (!sample || sample->extrapolated);
  };
  Tilt tilt;
  tilt.extrapolated = guessed(body_, body) || guessed(plate_, plate);
  Pose3 T_world_body = Pose3::Identity();
  if (!body_.empty()) {
    T_world_body = body ? body->value : body_.newest();
  }
  const common::RollPitchYaw rpy =
      common::rpyFromRotation(T_world_body.linear() * T_body_lidar(utime).linear());
  tilt.attitude = {rpy.roll, rpy.pitch};
  return tilt;
}

double ScanContext::heightAt(Utime utime) const {
  const auto body = body_.at(utime);
  return body ? (body->value * T_body_lidar(utime)).translation().z() - robot_.lidarHeight() : 0.0;
}

std::optional<common::Pose2> ScanContext::fusedPose(Utime utime) const {
  const auto body = body_.covers(utime) ? body_.at(utime) : std::nullopt;
  return body ? std::optional(planar(body->value * T_body_lidar(utime))) : std::nullopt;
}

std::optional<MotionPrior> ScanContext::takePrior(Utime utime, PriorSource source) {
  const std::optional<Pose3> T_odom_last = std::exchange(T_odom_lidar_last_, std::nullopt);
  const std::optional<common::Pose2> T_world_last = std::exchange(T_world_lidar_last_, std::nullopt);
  if (const auto body = body_.at(utime)) {
    T_world_lidar_last_ = planar(body->value * T_body_lidar(utime));
  }
  if (const auto odometry = odometry_.at(utime)) {
    T_odom_lidar_last_ = odometry->value * robot_.T_body_lidar();
  }
  if (source == PriorSource::kFusedPose) {
    return T_world_last && T_world_lidar_last_
               ? std::optional(MotionPrior{T_world_last->inverse() * *T_world_lidar_last_})
               : std::nullopt;
  }
  if (!T_odom_last || !T_odom_lidar_last_) {
    return std::nullopt;
  }
  return MotionPrior{planar(T_odom_last->inverse() * *T_odom_lidar_last_)};
}

}  // namespace rubble::slam_lidar
