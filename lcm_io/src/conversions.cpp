#include "lcm_io/conversions.h"

#include <cmath>

#include "common/error.h"

namespace rubble::lcm_io {

common::Pose3 poseFromMessage(const double* p, const double* q) {
  const Eigen::Quaterniond rotation(q[0], q[1], q[2], q[3]);
  const Eigen::Vector3d translation(p[0], p[1], p[2]);
  if (!translation.allFinite() || !(rotation.norm() > 1e-6 && rotation.norm() < 1e6)) {
    throw common::Error("pose that is not finite or whose quaternion is far from unit length");
  }
  common::Pose3 T = common::Pose3::Identity();
  T.linear() = rotation.normalized().toRotationMatrix();
  T.translation() = translation;
  return T;
}

void poseToMessage(const common::Pose3& T, double* p, double* q) {
  const Eigen::Quaterniond rotation(T.linear());
  for (int i = 0; i < 3; ++i) {
    p[i] = T.translation()[i];
  }
  q[0] = rotation.w();
  q[1] = rotation.x();
  q[2] = rotation.y();
  q[3] = rotation.z();
}

common::RobotConfig::Intrinsics intrinsicsFromMessage(const rubble::camera_info_t& info) {
  common::RobotConfig::Intrinsics intrinsics{info.width,     info.height,        info.rate_hz,
                                             info.model,     {info.fx, info.fy}, {info.cx, info.cy},
                                             info.distortion};
  bool ok = info.width > 0 && info.height > 0 && info.fx > 0.0 && info.fy > 0.0;
  for (const auto& values : {intrinsics.focal, intrinsics.centre, intrinsics.distortion}) {
    for (const double value : values) {
      ok = ok && std::isfinite(value);
    }
  }
  if (!ok) {
    throw common::Error("calibration with a size or focal length <= 0, or with values that are not finite");
  }
  return intrinsics;
}

void intrinsicsToMessage(const common::RobotConfig::Intrinsics& intrinsics, rubble::camera_info_t& info) {
  info.width = intrinsics.width;
  info.height = intrinsics.height;
  info.rate_hz = intrinsics.rate;
  info.fx = intrinsics.focal[0];
  info.fy = intrinsics.focal[1];
  info.cx = intrinsics.centre[0];
  info.cy = intrinsics.centre[1];
  info.model = intrinsics.model;
  info.distortion = intrinsics.distortion;
  info.ndistortion = static_cast<std::int32_t>(intrinsics.distortion.size());
}

}  // namespace rubble::lcm_io
