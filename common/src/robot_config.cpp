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

void visitIntrinsics(ConfigSection& section, RobotConfig::Intrinsics& lens) {
  section.integer("width", lens.width, "pixels", 16, 8192, "of a picture");
  section.integer("height", lens.height, "pixels", 16, 8192, "of a picture");
  section.number("rate", lens.rate, "Hz", 1.0, 240.0, "pictures per second");
  section.choice("model", lens.model, {"pinhole", "fisheye"},
                 "radial-tangential distortion (k1 k2 p1 p2), or equidistant (k1 k2 k3 k4)");
  section.numbers("focal", lens.focal, "pixels", 1.0, 1e5, "fx, fy");
  section.numbers("centre", lens.centre, "pixels", -1e4, 1e4, "cx, cy; the first pixel's centre is 0");
  section.numbers("distortion", lens.distortion, "", -10.0, 10.0, "four coefficients of the model");
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
  ConfigSection& camera =
      section.section("camera", "T_body_camera, optical frame: x right, y down, z forward; and its lens");
  visitMount(camera, config.camera, "x, y, z in body");
  visitIntrinsics(camera, config.intrinsics);
}

}  // namespace rubble::common
