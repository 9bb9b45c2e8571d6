#include "samples/robot_views.h"

#include <cmath>
#include <numbers>

#include "arena_sim/mission.h"

namespace rubble::arena_sim {

namespace {

using Eigen::Vector2d;

constexpr std::uint32_t kStream = 40;
constexpr double kClearance = 0.3;     // m, of the robot's middle
constexpr double kPause = 10.0;        // s from one picture to the next
constexpr double kTilt = 0.04;         // rad, of the robot: ground is not quite flat
constexpr double kLift = 0.12;         // m
constexpr double kOffCentre = 0.35;    // rad, that the robot looks past an object
constexpr double kFarthestSide = 1.3;  // rad, from a victim's y axis or a picture's front to the robot
constexpr double kTurning = 0.4;       // rad/s
constexpr double kDriving = 0.3;       // m/s

}  // namespace

Eigen::Vector3d middleOf(const Surface& surface) {
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  for (const Surface::Vertex& vertex : surface.vertices) {
    sum += vertex.p_world;
  }
  return sum.cast<double>() / static_cast<double>(surface.vertices.size());
}

RobotViews::RobotViews(const World& world, std::uint64_t seed)
    : robot_(arenaRobot()),
      random_(randomStream(seed, kStream)),
      clearance_(world.obstacles),
      bounds_(boundsOf(world.obstacles)),
      camera_({}, robot_.intrinsics, std::make_shared<const Scene>(world.scene),
              std::make_shared<const RayTracer>(world.scene), seed) {}

common::Pose3 RobotViews::anywhere() {
  const auto somewhere = [&] {
    return Vector2d(random_.uniform(bounds_.min().x(), bounds_.max().x()),
                    random_.uniform(bounds_.min().y(), bounds_.max().y()));
  };
  Vector2d p = somewhere();
  while (clearance_.clearance(p) < kClearance) {
    p = somewhere();
  }
  return cameraAt(p, random_.uniform(-std::numbers::pi, std::numbers::pi));
}

std::optional<common::Pose3> RobotViews::towards(const WorldObject& object, double distance) {
  const Eigen::Matrix3d R = object.T_world_object.linear();
  return around(object.T_world_object.translation(), distance, [&](double side) -> Eigen::Vector3d {
    return R * Eigen::Vector3d(std::sin(side), random_.sign() * std::cos(side), 0.0);
  });
}

std::optional<common::Pose3> RobotViews::before(const Surface& picture, double distance) {
  const Eigen::Vector3d front = picture.vertices.front().normal.cast<double>();
  return around(middleOf(picture), distance, [&](double side) -> Eigen::Vector3d {
    return Eigen::AngleAxisd(side, Eigen::Vector3d::UnitZ()) * front;
  });
}

std::optional<common::Pose3> RobotViews::around(
    const Eigen::Vector3d& target, double distance,
    const std::function<Eigen::Vector3d(double side)>& direction_at) {
  constexpr int kAttempts = 50;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    const double side = random_.sign() * random_.uniform(0.0, kFarthestSide);
    const Vector2d p = target.head<2>() + distance * direction_at(side).head<2>();
    if (clearance_.clearance(p) >= kClearance) {
      const Vector2d ahead = target.head<2>() - p;
      return cameraAt(p, std::atan2(ahead.y(), ahead.x()) + random_.uniform(-kOffCentre, kOffCentre));
    }
  }
  return std::nullopt;
}

cv::Mat RobotViews::take(const common::Pose3& T_world_camera) {
  // The exposure has followed what the camera sees.
  camera_.take(seconds_ += kPause, [&](double) { return T_world_camera; });
  seconds_ += kPause;
  const double turning = random_.uniform(-kTurning, kTurning);
  const double driving = random_.uniform(0.0, kDriving);
  const double start = seconds_;
  const auto pose = [&](double seconds) {
    const double dt = seconds - start;
    return T_world_camera * common::Pose3(Eigen::Translation3d(0.0, 0.0, driving * dt)) *
           common::Pose3(Eigen::AngleAxisd(-turning * dt, Eigen::Vector3d::UnitY()));
  };
  return camera_.take(seconds_, pose).bgr;
}

/// A camera over p.
common::Pose3 RobotViews::cameraAt(const Vector2d& p, double yaw) {
  common::Pose3 T = common::pose3FromPose2({p.x(), p.y(), yaw}, random_.uniform(0.0, kLift));
  T.linear() = T.linear() * (Eigen::AngleAxisd(random_.uniform(-kTilt, kTilt), Eigen::Vector3d::UnitY()) *
                             Eigen::AngleAxisd(random_.uniform(-kTilt, kTilt), Eigen::Vector3d::UnitX()))
                                .toRotationMatrix();
  common::Pose3 T_body_camera = robot_.T_body_camera();
  T_body_camera.translation().head<2>().setZero();
  return T * T_body_camera;
}

}  // namespace rubble::arena_sim
