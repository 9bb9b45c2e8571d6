#include "scan_context.h"

#include <cmath>
#include <utility>

#include "common/error.h"

namespace rubble::slam_lidar {

using common::Pose3;
using common::Utime;

void ScanContext::addPlate(Utime utime, double roll, double pitch) {
  if (!std::isfinite(roll) || !std::isfinite(pitch)) {
    throw common::Error("plate angles that are not finite");
  }
  plate_.add(utime, {roll, pitch});
}

void ScanContext::addBody(Utime utime, const Pose3& T_world_body) {
  const common::RollPitchYaw rpy = common::rpyFromRotation(T_world_body.linear());
  body_.add(utime, {rpy.roll, rpy.pitch});
}

void ScanContext::addOdometry(Utime utime, const Pose3& T_odom_body) { odometry_.add(utime, T_odom_body); }

bool ScanContext::complete(Utime first, Utime last) const {
  return (plate_.silent(last) || plate_.covers(last)) && (body_.silent(last) || body_.covers(last)) &&
         (odometry_.silent(first) || odometry_.covers(first));
}

ScanContext::Tilt ScanContext::tiltAt(Utime utime) const {
  Tilt tilt;
  const auto angles = [&](const History<Eigen::Vector2d>& history) -> Eigen::Vector2d {
    if (history.empty()) {
      return {0.0, 0.0};
    }
    const auto sample = history.at(utime);
    tilt.extrapolated = tilt.extrapolated || !sample || sample->extrapolated;
    return sample ? sample->value : history.newest();
  };
  const Eigen::Vector2d body = angles(body_);
  const Eigen::Vector2d plate = angles(plate_);
  const Eigen::Matrix3d R_level_body = common::rotationFromRpy({body.x(), body.y(), 0.0});
  const Pose3 T_body_lidar = robot_.T_body_plate(plate.x(), plate.y()) * robot_.lidar.pose();
  const common::RollPitchYaw rpy = common::rpyFromRotation(R_level_body * T_body_lidar.linear());
  tilt.attitude = {rpy.roll, rpy.pitch};
  return tilt;
}

std::optional<MotionPrior> ScanContext::takePrior(Utime utime) {
  const std::optional<Pose3> last = std::exchange(T_odom_lidar_last_, std::nullopt);
  const auto sample = odometry_.at(utime);
  if (!sample) {
    return std::nullopt;
  }
  T_odom_lidar_last_ = sample->value * robot_.T_body_lidar();
  if (!last) {
    return std::nullopt;
  }
  const Pose3 T_last_now = last->inverse() * *T_odom_lidar_last_;
  const double yaw = common::rpyFromRotation(T_last_now.linear()).yaw;
  return MotionPrior{.T_previous_now = {T_last_now.translation().x(), T_last_now.translation().y(), yaw}};
}

}  // namespace rubble::slam_lidar
