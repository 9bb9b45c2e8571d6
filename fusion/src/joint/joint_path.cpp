#include "joint/joint_path.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace rubble::fusion {

using common::Pose3;
using common::Utime;

namespace {

/// States come at most so often; in H, where they should come with a scan, without any after so long.
constexpr Utime kPeriod = common::kMicrosecondsPerSecond / 10;
constexpr Utime kSilence = common::kMicrosecondsPerSecond / 4;
/// What is known where the window begins: m, rad, s.
constexpr double kStartPosition = 0.02;
constexpr double kStartRotation = 0.01;
constexpr double kUnknownTilt = 0.5;
constexpr double kStartClock = 0.01;
/// A correction of the monocular map changes its scale here by about so much.
constexpr double kCorrectedScale = 0.03;
constexpr double kLeastScaleSigma = 0.01;
/// What the level's grid is off itself (m, rad): no scan tells, and the window takes it for world.
constexpr double kGridPosition = 0.01;
constexpr double kGridHeading = 0.002;
/// The floor is flat and level up to this (m, rad). A body that could stand on it by all that is known (so
/// many deviations), and could over this way (m), does.
constexpr double kFloorHeight = 0.015;
constexpr double kFloorTilt = 0.007;
constexpr double kGate = 3.0;
constexpr double kFloorWay = 0.3;

}  // namespace

JointPath::JointPath(const JointConfig& config, const Pose3& T_camera_body)
    : T_camera_body_(T_camera_body), window_(config, T_camera_body) {}

double JointPath::scale() const { return std::exp(estimate_->state.log_scale); }

Eigen::Matrix<double, 6, 6> JointPath::covariance() const {
  Eigen::Matrix<double, 6, 6> P = estimate_->covariance.topLeftCorner<6, 6>();
  P(0, 0) += kGridPosition * kGridPosition;
  P(1, 1) += kGridPosition * kGridPosition;
  P(5, 5) += kGridHeading * kGridHeading;
  return P;
}

void JointPath::addScale(Utime utime, double log_scale) { scale_ = Scale{utime, log_scale}; }

void JointPath::begin(const Track& last, const JointStart& start) {
  if (active()) {
    JointVector sigmas = estimate_->covariance.diagonal().cwiseSqrt();
    sigmas(6) = std::max(sigmas(6), kCorrectedScale);
    begin(last, sigmas);
    return;
  }
  const double tilt = start.attitude_known ? kStartRotation : kUnknownTilt;
  JointVector sigmas;
  sigmas << Eigen::Vector3d::Constant(std::hypot(kStartPosition, start.drift)), tilt, tilt, kStartRotation,
      std::max(start.scale_sigma, kLeastScaleSigma), kStartClock;
  estimate_.emplace().state.log_scale = std::log(start.scale);
  begin(last, sigmas);
}

void JointPath::begin(const Track& last, const JointVector& sigmas) {
  estimate_->state.T_world_camera = last.T_world_camera;
  window_.restart(estimate_->state, sigmas);
  estimate_ = window_.solve();
  utime_ = last.utime;
  map_id_ = last.map_id;
  map_revision_ = last.map_revision;
  floor_way_ = 0.0;
}

void JointPath::restart(const RecentPath& path) {
  begin(path.last(), estimate_->covariance.diagonal().cwiseSqrt());
}

void JointPath::changeLevel(const RecentPath& path, const Eigen::Vector4d& sigmas) {
  JointVector all = estimate_->covariance.diagonal().cwiseSqrt();
  all.head<3>() = sigmas.head<3>();
  all(5) = sigmas(3);
  begin(path.last(), all);
}

void JointPath::follow(RecentPath& path, const JointStart& start, const PlaneState& plane) {
  const Track& last = path.last();
  if (active() && last.map_id != map_id_) {
    stop();
  }
  if (!active() || last.map_revision != map_revision_) {
    begin(last, start);
  } else if (last.utime - utime_ >= (plane.state() == ControlState::kH ? kSilence : kPeriod)) {
    add(path, last.utime, std::nullopt, plane);
  }
}

bool JointPath::addLidar(RecentPath& path, Utime utime, const LidarFix& lidar, const PlaneState& plane,
                         bool at_once) {
  const bool used = utime - utime_ >= (at_once ? 1 : kPeriod);
  if (used) {
    add(path, utime, lidar, plane);
  }
  return used;
}

bool JointPath::standsOnFloor(const Pose3& T_world_camera, double way, const PlaneState& plane) {
  const Pose3 T_world_body = T_world_camera * T_camera_body_;
  const Eigen::Vector3d up = T_world_body.linear().col(2);
  const JointMatrix& P = estimate_->covariance;
  // A turn about x moves the body's up along -y, one about y along x.
  const bool may = plane.state() == ControlState::kH &&
                   std::abs(T_world_body.translation().z() - plane.level().floor) <=
                       kGate * std::hypot(kFloorHeight, std::sqrt(P(2, 2))) &&
                   std::abs(up.y()) <= kGate * std::hypot(kFloorTilt, std::sqrt(P(3, 3))) &&
                   std::abs(up.x()) <= kGate * std::hypot(kFloorTilt, std::sqrt(P(4, 4)));
  floor_way_ = may ? floor_way_ + way : 0.0;
  return floor_way_ >= kFloorWay;
}

void JointPath::add(RecentPath& path, Utime utime, const std::optional<LidarFix>& lidar,
                    const PlaneState& plane) {
  const auto before = path.at(utime_);
  const auto now = path.at(utime);
  if (!before || !now) {
    begin(path.last(), JointStart{});
    return;
  }
  const Pose3 T_before_now = before->inverse() * *now;
  JointMeasurements measured;
  measured.lidar = lidar;
  if (standsOnFloor(*now, T_before_now.translation().norm(), plane)) {
    measured.floor = plane.level().floor;
  }
  if (scale_ && utime - scale_->utime <= kSilence) {
    measured.log_scale = scale_->log_scale;
  }
  scale_.reset();
  window_.add({T_before_now, estimate_->state.log_scale}, measured);
  estimate_ = window_.solve();
  utime_ = utime;
  Pose3 T = estimate_->state.T_world_camera * now->inverse();
  T.linear() = Eigen::Quaterniond(T.linear()).normalized().toRotationMatrix();
  path.correct(T);
}

}  // namespace rubble::fusion
