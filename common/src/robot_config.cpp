#include "common/robot_config.h"

namespace rubble::common {

namespace {

constexpr double kFarthest = 2.0;
constexpr double kLargestAngle = 3.2;

void visitTranslation(ConfigSection& section, std::vector<double>& translation, const char* doc) {
  section.numbers("translation", translation, "m", -kFarthest, kFarthest, doc);
}

void visitMount(ConfigSection& section, RobotConfig::Mount& mount, const char* parent) {
  visitTranslation(section, mount.translation, parent);
  section.numbers("rpy", mount.rpy, "rad", -kLargestAngle, kLargestAngle, "roll, pitch, yaw (Z-Y-X)");
}

}  // namespace

Pose3 RobotConfig::Mount::pose() const {
  Pose3 T = Pose3::Identity();
  T.linear() = rotationFromRpy({rpy[0], rpy[1], rpy[2]});
  T.translation() = Eigen::Vector3d(translation[0], translation[1], translation[2]);
  return T;
}

Pose3 RobotConfig::T_body_plate(double roll, double pitch) const {
  Pose3 T = Pose3::Identity();
  T.linear() =
      (Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX()) * Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()))
          .toRotationMatrix();
  T.translation() = Eigen::Vector3d(plate_translation[0], plate_translation[1], plate_translation[2]);
  return T;
}

Pose3 RobotConfig::T_body_lidar() const { return T_body_plate(0.0, 0.0) * lidar.pose(); }

void visit(ConfigSection& section, RobotConfig& config) {
  visitTranslation(section.section("plate", "stabiliser: T_body_plate at zero angles"),
                   config.plate_translation, "x, y, z of the crossing of its axes in body");
  ConfigSection& lidar = section.section("lidar", "T_plate_lidar: x forward, z up");
  visitMount(lidar, config.lidar, "x, y, z in plate");
  lidar.number("sweep_time_s", config.lidar_sweep_time_s, "s", 0.0, 0.2,
               "first beam of a scan to one step after the last");
  visitMount(section.section("camera", "T_body_camera, optical frame: x right, y down, z forward"),
             config.camera, "x, y, z in body");
}

}  // namespace rubble::common
