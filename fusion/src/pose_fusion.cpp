#include "pose_fusion.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "common/error.h"
#include "rotation_vector.h"

namespace rubble::fusion {

using common::Pose2;
using common::Pose3;
using common::Utime;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// Span over which the LiDAR's velocity at a sample is taken.
constexpr Utime kVelocitySpan = common::kMicrosecondsPerSecond / 10;
/// Scans that wait for vision: one second.
constexpr std::size_t kMostWaiting = 40;
/// How long the LiDAR's poses in H wait for the monocular map's pictures.
constexpr Utime kLidarSpan = 8 * common::kMicrosecondsPerSecond;
/// Share of a scan's motion in the velocity that carries the pose without vision.
constexpr double kVelocityGain = 0.3;
/// Silence after which a sensor no longer carries the pose.
constexpr Utime kSilence = common::kMicrosecondsPerSecond / 5;
/// LiDAR and vision agree within this (m, rad) and the drift since they last did: from scan to scan, and
/// after M.
constexpr double kJumpWay = 0.08;
constexpr double kJumpTurn = 0.05;
constexpr double kReturnWay = 0.3;
constexpr double kReturnTurn = 0.2;
/// Tilt of the LiDAR's plane (rad) beyond which its poses mean nothing even where the tilt is a guess.
constexpr double kHopelessTilt = 0.12;
/// Drift of vision, share of the way; and of nothing at all, m/s.
constexpr double kDrift = 0.05;
constexpr double kBlindDrift = 0.5;
/// Deviation of a position that has drifted at most so far, share.
constexpr double kDriftSigma = 0.4;
/// Time without any sight of the attitude (s) after which the robot is taken to stand level, until the LiDAR
/// agrees.
constexpr double kForgetTilt = 5.0;
/// The attitude is predicted no further than this, s.
constexpr double kFarthestPrediction = 0.2;
/// How a tracked body swings on: regression of the next 65 ms on the turns of the last two pictures, on the
/// arena's ramps.
constexpr double kSwingLast = 1.2;
constexpr double kSwingBefore = 0.45;
/// So many measurements of a new map's scale by ranges in a row that lie within this (logarithms) are it, so
/// good; as if learnt on a way (m) that is none yet.
constexpr std::size_t kAnchors = 5;
constexpr double kAnchorSpread = 0.06;
constexpr double kAnchorSigma = 0.03;
constexpr double kAnchorWay = 0.01;
/// x, y, z, heading in the covariance of a pose; and how sure they are where a level begins, m and rad: what
/// its first scan is off the pose.
constexpr std::array kPlanar = {0, 1, 2, 5};
const Eigen::Vector4d kLevelBegins(0.01, 0.01, 0.02, 0.005);
/// Tilt of the body (rad) up to which the ground counts as level while nothing sees the attitude.
constexpr double kLevelGround = 0.05;

Pose3 scaled(Pose3 T, double scale) {
  T.translation() *= scale;
  return T;
}

double tiltOf(const Matrix3d& R) { return std::acos(std::clamp(R(2, 2), -1.0, 1.0)); }

Pose2 planar(const Pose3& T) {
  return {T.translation().x(), T.translation().y(), common::rpyFromRotation(T.linear()).yaw};
}

/// Turns about `pivot`, then shifts.
Pose3 motionAbout(const Vector3d& pivot, const Vector3d& turn, const Vector3d& shift) {
  Pose3 T = Pose3::Identity();
  T.linear() = rotationFromVector(turn);
  T.translation() = pivot - T.linear() * pivot + shift;
  return T;
}

}  // namespace

PoseFusion::PoseFusion(const FusionConfig& config, const common::RobotConfig& robot)
    : config_(config),
      robot_(robot),
      T_camera_body_(robot.T_body_camera().inverse()),
      plane_(config.plane),
      lidar_(kLidarSpan),
      window_(config, robot.T_body_camera()) {
  if (config.plane.mode == "joint") {
    joint_.emplace(config.joint, T_camera_body_);
  }
}

void PoseFusion::addPlate(Utime utime, double roll, double pitch) { plate_.add(utime, {roll, pitch}); }

Pose3 PoseFusion::T_camera_lidar(Utime utime) const {
  Eigen::Vector2d angles = Eigen::Vector2d::Zero();
  if (!plate_.empty()) {
    const auto sample = plate_.at(utime);
    angles = sample ? sample->value : plate_.newest();
  }
  return T_camera_body_ * robot_.T_body_plate(angles.x(), angles.y()) * robot_.lidar.pose();
}

Plane PoseFusion::planeOf(const Pose3& T_world_camera, Utime utime) const {
  const Pose3 T_world_lidar = T_world_camera * T_camera_lidar(utime);
  return {T_world_lidar.translation().z() - robot_.lidarHeight(), tiltOf(T_world_lidar.linear()),
          tiltOf(T_world_camera.linear() * T_camera_body_.linear())};
}

bool PoseFusion::lidarMatches(Utime now) const { return last_lidar_ > 0 && now - last_lidar_ <= kSilence; }

std::optional<MapAlignment> PoseFusion::alignment() const {
  const auto found = maps_.find(map_id_);
  return found == maps_.end() ? std::nullopt : std::optional(found->second);
}

Pose3 PoseFusion::extrapolate(Utime utime) const {
  if (path_.empty()) {
    return robot_.T_body_camera();  // The robot starts level at the origin of world.
  }
  const Track& last = path_.last();
  const double dt = common::secondsFromUtime(utime - last.utime);
  if (!visionCarries()) {
    // Without anything that sees motion the robot is taken to stand.
    const Vector3d& v = lidar_velocity_;
    return lidarMatches(last.utime) ? motionAbout(last.T_world_camera.translation(), {0.0, 0.0, dt * v.z()},
                                                  {dt * v.x(), dt * v.y(), 0.0}) *
                                          last.T_world_camera
                                    : last.T_world_camera;
  }
  const Track& earlier = path_.shortlyBefore();
  if (earlier.utime == last.utime) {
    return last.T_world_camera;
  }
  const double fraction =
      static_cast<double>(utime - earlier.utime) / static_cast<double>(last.utime - earlier.utime);
  return common::blend(earlier.T_world_camera, last.T_world_camera, fraction);
}

Pose3 PoseFusion::carry(const MonoMeasurement& mono) {
  const Pose3 T_predicted = extrapolate(mono.utime);
  if (!mono.tracking) {
    return T_predicted;
  }
  const auto known = maps_.find(mono.map_id);
  if (known == maps_.end()) {
    // A new map inherits the attitude.
    MapAlignment alignment;
    alignment.S_world_mono.R = T_predicted.linear() * mono.T_mono_camera.linear().transpose();
    maps_.emplace(mono.map_id, alignment);
    return T_predicted;
  }
  const MapAlignment& alignment = known->second;
  const Pose3 T_aligned = alignment.S_world_mono * mono.T_mono_camera;
  const Track* last = path_.empty() ? nullptr : &path_.last();
  const bool goes_on = last != nullptr && last->tracking && last->map_id == mono.map_id &&
                       last->map_revision == mono.map_revision;
  if (goes_on) {
    Pose3 T = last->T_world_camera * scaled(last->T_mono_camera.inverse() * mono.T_mono_camera,
                                            jointHolds() ? joint_->scale() : alignment.S_world_mono.scale);
    if (!visionCarries()) {
      T.translation().head<2>() = T_predicted.translation().head<2>();
      if (!alignment.scale_known || alignment.way == 0.0) {
        T.translation().z() = T_predicted.translation().z();
      }
    }
    return T;
  }
  if (last != nullptr && last->tracking && last->map_id == mono.map_id) {
    // The map was corrected under the pose: that does not move the robot.
    corrected_.begin(mono.map_id, last->utime, last->T_world_camera, mono.utime);
    return T_predicted;
  }
  // Vision is back, or in another map.
  if (!alignment.scale_known) {
    Pose3 T = T_predicted;
    T.linear() = T_aligned.linear();
    return T;
  }
  attitude_known_ = true;
  if (plane_.state() != ControlState::kH || !lidarMatches(mono.utime)) {
    anchored_ = false;
    return T_aligned;
  }
  return planarAs(T_predicted, T_aligned);  // In H world is the LiDAR's.
}

Pose3 PoseFusion::planarAs(const Pose3& T_world_camera, const Pose3& T_seen) const {
  const double turn = planar(T_world_camera * T_camera_body_).yaw - planar(T_seen * T_camera_body_).yaw;
  Pose3 T = motionAbout(T_seen.translation(), {0.0, 0.0, turn}, Vector3d::Zero()) * T_seen;
  T.translation().head<2>() = T_world_camera.translation().head<2>();
  return T;
}

void PoseFusion::mendMotion() {
  const auto motion = corrected_.take();
  const auto after = motion ? path_.at(motion->after) : std::nullopt;
  const auto scale = scaleOf(map_id_);
  if (!after || !scale) {
    return;
  }
  const Pose3& T_guessed = path_.last().T_world_camera;
  Pose3 T_mended =
      motion->T_world_before * scaled(motion->T_before_after, *scale) * after->inverse() * T_guessed;
  if (plane_.state() == ControlState::kH && lidarMatches(path_.last().utime)) {
    T_mended = planarAs(T_guessed, T_mended);  // Scans have mended the rest.
  }
  path_.correctFrom(motion->after, T_mended * T_guessed.inverse());
  if (jointHolds()) {
    joint_->restart(path_);
  }
}

RobotState PoseFusion::state() const {
  const Track& track = path_.last();
  RobotState state;
  state.utime = track.utime;
  state.T_world_body = track.T_world_camera * T_camera_body_;
  state.attitude_known = attitude_known_;
  if (const Track& earlier = path_.shortlyBefore(); earlier.utime < track.utime) {
    const Pose3 T_world_before = earlier.T_world_camera * T_camera_body_;
    const double dt = common::secondsFromUtime(track.utime - earlier.utime);
    state.v_world_body = (state.T_world_body.translation() - T_world_before.translation()) / dt;
    state.w_body = rotationVector(T_world_before.linear().transpose() * state.T_world_body.linear()) / dt;
  }
  state.covariance = covariance();
  return state;
}

Eigen::Matrix<double, 6, 6> PoseFusion::covariance() const {
  const Pose3& T_world_camera = path_.last().T_world_camera;
  Eigen::Matrix<double, 6, 6> P = Eigen::Matrix<double, 6, 6>::Zero();
  if (jointHolds()) {
    Eigen::Matrix<double, 6, 6> J = Eigen::Matrix<double, 6, 6>::Identity();
    J.topRightCorner<3, 3>() = -skew(T_world_camera.linear() * T_camera_body_.translation());
    P = J * joint_->covariance() * J.transpose();
  } else {
    const double drift = kDriftSigma * drift_;
    P.topLeftCorner<2, 2>() = lidar_covariance_.topLeftCorner<2, 2>();
    P(0, 0) += 1e-4 + drift * drift;
    P(1, 1) += 1e-4 + drift * drift;
    P(2, 2) = 2.5e-3 + drift * drift + (attitude_known_ ? 0.0 : 1.0);
    const double tilt = attitude_known_ ? 0.01 + 0.002 * time_without_vision_ : 0.5;
    P(3, 3) = P(4, 4) = tilt * tilt;
    P(5, 5) = lidar_covariance_(2, 2) + 1e-5 + 1e-4 * drift_;
  }
  const Level& level = plane_.levels()[static_cast<std::size_t>(level_)];
  P(kPlanar, kPlanar) += levelCovariance(level, (T_world_camera * T_camera_body_).translation().head<2>());
  return P;
}

void PoseFusion::followLevel() {
  if (plane_.levelId() == level_) {
    return;
  }
  const Eigen::Matrix4d now = covariance()(kPlanar, kPlanar);
  level_ = plane_.levelId();
  const bool begins = level_ > 0 && plane_.level().covariance.isZero();
  if (begins) {
    plane_.link((path_.last().T_world_camera * T_camera_body_).translation().head<2>(), now);
  }
  if (jointHolds()) {
    joint_->changeLevel(path_, begins ? kLevelBegins : now.diagonal().cwiseSqrt());
  }
}

RobotState PoseFusion::addTrack(const Track& track) {
  if (!path_.empty()) {
    const Track& last = path_.last();
    const double dt = common::secondsFromUtime(track.utime - last.utime);
    const double way = (track.T_world_camera.translation() - last.T_world_camera.translation()).norm();
    drift_ += visionCarries() ? kDrift * way : kBlindDrift * dt;
    time_without_vision_ = track.tracking ? 0.0 : time_without_vision_ + dt;
  }
  path_.add(track);
  watchAttitude();
  if (joint_ && !visionCarries()) {
    joint_->stop();
  } else if (joint_ && track.tracking) {
    const MapAlignment& map = maps_.at(map_id_);
    joint_->follow(path_, {map.S_world_mono.scale, map.scale_sigma, kDriftSigma * drift_, attitude_known_},
                   plane_);
  }
  useWaiting();
  plane_.addPlane(track.utime, planeOf(path_.last().T_world_camera, track.utime), attitude_known_);
  followLevel();
  return state();
}

void PoseFusion::watchAttitude() {
  const Track& track = path_.last();
  const Matrix3d R_world_body = track.T_world_camera.linear() * T_camera_body_.linear();
  if (track.tracking || time_without_vision_ <= common::secondsFromUtime(kSilence)) {
    return;
  }
  if (tiltOf(R_world_body) > kLevelGround || plane_.state() == ControlState::kM ||
      !plane_.usable(planeOf(track.T_world_camera, track.utime))) {
    attitude_known_ = false;
  }
  if (!attitude_known_ && time_without_vision_ > kForgetTilt) {
    standLevel();
  }
}

void PoseFusion::standLevel() {
  const Pose3& T_world_camera = path_.last().T_world_camera;
  const Matrix3d R_world_body = T_world_camera.linear() * T_camera_body_.linear();
  const Matrix3d level = common::rotationFromRpy({0.0, 0.0, common::rpyFromRotation(R_world_body).yaw});
  path_.correct(motionAbout(T_world_camera.translation(), rotationVector(level * R_world_body.transpose()),
                            Vector3d::Zero()));
}

void PoseFusion::standOnFloor(const Plane& plane) {
  standLevel();
  path_.correct(
      motionAbout(Vector3d::Zero(), Vector3d::Zero(), {0.0, 0.0, plane_.level().floor - plane.height}));
}

RobotState PoseFusion::addMono(const MonoMeasurement& seen) {
  MonoMeasurement mono = seen;
  mono.tracking = seen.tracking && !turns_.astray();
  // A picture that was under way is worth more than states without one, and so are two pictures with a pause
  // between them.
  const bool paused = visionTracks();
  while (!path_.empty() && !path_.last().tracking && mono.tracking &&
         (paused || mono.utime <= path_.last().utime)) {
    path_.dropLast();
  }
  if (!path_.empty() && mono.utime <= path_.last().utime) {
    throw common::Error(fmt::format("picture at {} us is not newer than the last state, {} us", mono.utime,
                                    path_.last().utime));
  }
  mendMotion();
  if (seen.tracking && !path_.empty()) {
    const Matrix3d R_camera_lidar = T_camera_lidar(seen.utime).linear();
    turns_.addVision(seen.utime, seen.map_id, seen.map_revision, seen.T_mono_camera.linear() * R_camera_lidar,
                     path_.last().T_world_camera.linear() * R_camera_lidar);
  }
  if (mono.tracking) {
    if (mono.map_id != map_id_) {
      anchors_.clear();
    }
    map_id_ = mono.map_id;
    map_revision_ = mono.map_revision;
  }
  return addTrack(
      {mono.utime, carry(mono), mono.tracking, mono.map_id, mono.map_revision, mono.T_mono_camera});
}

RobotState PoseFusion::advance(Utime utime) { return addMono({utime, false, map_id_, map_revision_}); }

bool PoseFusion::visionTracks() const {
  const Track* tracked = path_.lastTracked();
  return tracked != nullptr && path_.last().utime - tracked->utime <= kSilence;
}

bool PoseFusion::visionCarries() const {
  const auto known = maps_.find(map_id_);
  if (!visionTracks() || known == maps_.end() || !known->second.scale_known) {
    return false;
  }
  const double way = known->second.way;
  const ControlState state = plane_.state();
  if (way == 0.0) {
    return state == ControlState::kM;  // A scale that was wrong is better than none.
  }
  return way >= config_.firm_way || state != ControlState::kH || !lidarMatches(path_.last().utime);
}

void PoseFusion::noteVelocity(const LidarMeasurement& lidar) {
  const double dt = common::secondsFromUtime(lidar.utime - last_lidar_);
  if (lidarMatches(lidar.utime) && dt > 0.0) {
    const Pose2& before = T_world_lidar_last_;
    const Vector3d v(lidar.T_world_lidar.x - before.x, lidar.T_world_lidar.y - before.y,
                     common::wrapAngle(lidar.T_world_lidar.yaw - before.yaw));
    lidar_velocity_ += kVelocityGain * (v / dt - lidar_velocity_);
  } else {
    lidar_velocity_.setZero();
  }
  last_lidar_ = lidar.utime;
  T_world_lidar_last_ = lidar.T_world_lidar;
}

void PoseFusion::addLidar(const LidarMeasurement& lidar) {
  waiting_.push_back(lidar);
  if (waiting_.size() > kMostWaiting) {
    waiting_.pop_front();
  }
  useWaiting();
}

void PoseFusion::useWaiting() {
  const Utime reached = visionTracks() ? path_.lastTracked()->utime : path_.empty() ? 0 : path_.last().utime;
  while (!waiting_.empty() && waiting_.front().utime <= reached) {
    const LidarMeasurement lidar = waiting_.front();
    waiting_.pop_front();
    useLidar(lidar);
  }
}

void PoseFusion::useLidar(const LidarMeasurement& lidar) {
  const bool current = lidar.revision < 0 || lidar.revision == plane_.revision();
  if (!path_.at(lidar.utime) || !current || plane_.state() == ControlState::kM) {
    return;
  }
  checkTurns(lidar);
  const Pose3 T_world_camera = *path_.at(lidar.utime);
  const Pose3 T_predicted = T_world_camera * T_camera_lidar(lidar.utime);
  const Plane plane = planeOf(T_world_camera, lidar.utime);
  const bool usable = plane_.usable(plane);
  const Pose2 predicted = planar(T_predicted);
  const Eigen::Vector2d shift = lidar.T_world_lidar.translation() - predicted.translation();
  const double turn = common::wrapAngle(lidar.T_world_lidar.yaw - predicted.yaw);
  const bool returns = plane_.state() == ControlState::kR;
  // Where vision does not carry, there is nothing to contradict.
  const bool wide = returns || came_back_ || !anchored_;
  const auto within = [&](double way, double most_turn) {
    return shift.norm() <= way + drift_ && std::abs(turn) <= most_turn;
  };
  const bool jumps = !within(kJumpWay, kJumpTurn);
  const bool near = wide ? within(kReturnWay, kReturnTurn) : !jumps;
  // A plane that vision sees tilted is not confirmed by a match, but in R contradicted by it: where LiDAR and
  // vision differ, and where they agree but for a tilt or height that may as well be vision's error.
  const bool agrees =
      (near || !visionCarries()) && !(returns && attitude_known_ && !usable && plane_.doubtful(plane));
  const bool counts = lidar.good && (usable || (returns && !agrees));
  const bool insisted = plane_.addScan(!counts  ? PlaneState::Scan::kUnmatched
                                       : agrees ? PlaneState::Scan::kAgrees
                                                : PlaneState::Scan::kContradicts);
  followLevel();
  const bool returned = returns && plane_.state() == ControlState::kH;
  if (returned) {
    attitude_known_ = true;
    came_back_ = true;
  }
  // Its scale ran away, or it took one place for another.
  if (insisted || (returned && jumps && plane_.contradictedOnLevelGround())) {
    if (!usable) {
      standOnFloor(plane);
    }
    distrustVision();
  }
  // An unknown tilt tells nothing about the plane.
  const bool follows = lidar.good && (usable || (!attitude_known_ && plane.tilt <= kHopelessTilt));
  if (!follows || plane_.state() == ControlState::kM ||
      (visionCarries() && attitude_known_ && !came_back_ && (returns || !near))) {
    return;
  }
  if (jointHolds() && anchored_) {
    const LidarFix fix{T_camera_lidar(lidar.utime), lidar.T_world_lidar, lidar_velocity_, lidar.covariance};
    const bool used = joint_->addLidar(path_, lidar.utime, fix, plane_, came_back_);
    came_back_ = came_back_ && !used;
  } else {
    const double gain = visionCarries() && !came_back_ && anchored_ ? config_.lidar_gain : 1.0;
    came_back_ = false;
    path_.correct(motionAbout(T_predicted.translation(), {0.0, 0.0, gain * turn},
                              {gain * shift.x(), gain * shift.y(), 0.0}));
    if (joint_) {
      joint_->stop();  // It begins anew from here.
    }
  }
  noteVelocity(lidar);
  anchored_ = true;
  drift_ = attitude_known_ ? 0.0 : drift_;
  lidar_covariance_ = lidar.covariance;
  if (plane_.state() == ControlState::kH && !lidar.tilt_guessed) {
    if (!lidar_.covers(lidar.utime - kSilence)) {
      lidar_ = common::History<Pose2>(kLidarSpan);  // Nobody knows where it was in between.
    }
    lidar_.add(lidar.utime, lidar.T_world_lidar);
  }
}

void PoseFusion::checkTurns(const LidarMeasurement& lidar) {
  const Plane plane = planeOf(*path_.at(lidar.utime), lidar.utime);
  const bool was_astray = turns_.astray();
  if (lidar.good && plane_.doubtful(plane)) {
    turns_.addLidar(lidar.utime, lidar.T_world_lidar.yaw);
  }
  if (!turns_.astray() || was_astray) {
    return;
  }
  standOnFloor(plane);
  maps_.erase(map_id_);
  anchors_.clear();
  window_.clear();
  if (joint_) {
    joint_->stop();
  }
}

void PoseFusion::distrustVision() {
  const Track& last = path_.last();
  MapAlignment& map = maps_[map_id_];
  map.way = 0.0;
  if (last.tracking) {
    map.S_world_mono.R = last.T_world_camera.linear() * last.T_mono_camera.linear().transpose();
  }
  window_.clear();
  if (joint_) {
    joint_->stop();
  }
}

void PoseFusion::addScale(Utime utime, double log_scale) {
  const auto map = maps_.find(map_id_);
  if (!joint_ || map == maps_.end()) {
    return;
  }
  if (map->second.scale_known) {
    joint_->addScale(utime, log_scale);
    anchors_.clear();
    return;
  }
  anchors_.push_back(log_scale);
  if (anchors_.size() > kAnchors) {
    anchors_.pop_front();
  }
  const auto [least, most] = std::minmax_element(anchors_.begin(), anchors_.end());
  if (anchors_.size() == kAnchors && *most - *least <= kAnchorSpread) {
    anchor(map->second, std::exp(0.5 * (*least + *most)));
  }
}

void PoseFusion::anchor(MapAlignment& map, double scale) {
  const Track& last = path_.last();
  Similarity& S = map.S_world_mono;
  S.scale = scale;
  S.p = last.T_world_camera.translation() - scale * (S.R * last.T_mono_camera.translation());
  map.scale_sigma = kAnchorSigma;
  map.scale_known = true;
  map.way = kAnchorWay;
}

std::optional<double> PoseFusion::scaleOf(std::int32_t map_id) const {
  if (jointHolds() && map_id == map_id_) {
    return joint_->scale();
  }
  const auto known = maps_.find(map_id);
  return known != maps_.end() && known->second.scale_known ? std::optional(known->second.S_world_mono.scale)
                                                           : std::nullopt;
}

void PoseFusion::addPictures(std::span<const common::AnchoredPose> pictures,
                             const common::KeyframePoses& keyframes, std::int64_t revision) {
  addSamples(pictures);
  corrected_.addPictures(pictures, keyframes, revision == map_revision_);
  if (revision == map_revision_) {
    solve(keyframes);
  }
}

void PoseFusion::addSamples(std::span<const common::AnchoredPose> pictures) {
  for (const common::AnchoredPose& picture : pictures) {
    const auto at = [&](Utime utime) -> std::optional<Pose2> {
      const auto lidar = lidar_.covers(utime) ? lidar_.at(utime) : std::nullopt;
      return lidar && !lidar->extrapolated ? std::optional(lidar->value) : std::nullopt;
    };
    const auto T = at(picture.utime);
    const auto before = at(picture.utime - kVelocitySpan / 2);
    const auto after = at(picture.utime + kVelocitySpan / 2);
    if (T && before && after) {
      const double dt = common::secondsFromUtime(kVelocitySpan);
      const Vector3d v((after->x - before->x) / dt, (after->y - before->y) / dt,
                       common::wrapAngle(after->yaw - before->yaw) / dt);
      window_.add(picture, {Pose3::Identity(), T_camera_lidar(picture.utime), *T, v, plane_.level().floor});
    }
  }
}

void PoseFusion::solve(const common::KeyframePoses& keyframes) {
  const auto map = maps_.find(map_id_);
  if (map == maps_.end()) {
    return;
  }
  if (const auto solved = window_.solve(map_id_, keyframes, map->second)) {
    map->second = *solved;
    const Track& last = path_.last();
    if (last.tracking && last.map_id == map_id_ && last.map_revision == map_revision_ && !jointHolds()) {
      const Pose3 T_world_camera = solved->S_world_mono * last.T_mono_camera;
      if (plane_.state() == ControlState::kH) {
        pullToAlignment(T_world_camera);
      } else if (map_revision_ != solved_revision_) {
        goToAlignment(T_world_camera);
      }
    }
    solved_revision_ = map_revision_;
  }
}

void PoseFusion::goToAlignment(const Pose3& T_world_camera) {
  path_.correct(T_world_camera * path_.last().T_world_camera.inverse());
}

void PoseFusion::pullToAlignment(const Pose3& T_world_camera) {
  const Pose3& T_now = path_.last().T_world_camera;
  const double gain = config_.alignment_gain;
  Vector3d turn = gain * rotationVector(T_world_camera.linear() * T_now.linear().transpose());
  turn.z() = 0.0;
  const double height = T_world_camera.translation().z() - T_now.translation().z();
  path_.correct(motionAbout(T_now.translation(), turn, {0.0, 0.0, gain * height}));
}

FusionMemory PoseFusion::memory() const {
  FusionMemory memory;
  if (!path_.empty()) {
    memory.last = path_.last();
  }
  memory.state = plane_.state();
  memory.revision = plane_.revision();
  memory.levels = plane_.levels();
  memory.level = plane_.levelId();
  memory.attitude_known = attitude_known_;
  memory.maps = maps_;
  return memory;
}

void PoseFusion::restore(const FusionMemory& memory) {
  path_.add(memory.last);
  map_id_ = memory.last.map_id;
  map_revision_ = memory.last.map_revision;
  // A revision of its own: whoever heard the last one learns that something has changed.
  plane_.restore(memory.state, memory.revision + 1, memory.levels, memory.level);
  level_ = memory.level;
  attitude_known_ = memory.attitude_known;
  maps_ = memory.maps;
  anchored_ = false;
}

PlateAngles PoseFusion::levelling(Utime utime) const {
  if (path_.empty()) {
    return {};
  }
  const auto attitude = [&](std::size_t age) -> Matrix3d {
    return path_.ago(age).T_world_camera.linear() * T_camera_body_.linear();
  };
  const auto rate = [&](std::size_t age) -> Vector3d {
    const Utime dt = path_.ago(age).utime - path_.ago(age + 1).utime;
    return rotationVector(attitude(age + 1).transpose() * attitude(age)) / common::secondsFromUtime(dt);
  };
  Matrix3d R = attitude(0);
  if (path_.size() >= 3) {
    const double ahead = std::min(common::secondsFromUtime(utime - path_.last().utime), kFarthestPrediction);
    R = R * rotationFromVector(ahead * (kSwingLast * rate(0) - kSwingBefore * rate(1)));
  }
  return levellingAngles(R, config_.servo_range);
}

}  // namespace rubble::fusion
