#include "fusion/fusion_node.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <rubble/fusion_state_t.hpp>
#include <rubble/lidar_control_t.hpp>
#include <rubble/lidar_pose_t.hpp>
#include <rubble/mono_map_t.hpp>
#include <rubble/mono_pose_t.hpp>
#include <rubble/robot_pose_t.hpp>
#include <rubble/stabilizer_command_t.hpp>
#include <rubble/stabilizer_t.hpp>

#include "common/checkpoint_writer.h"
#include "common/error.h"
#include "common/files.h"
#include "fusion_config.h"
#include "joint/point_scale.h"
#include "lcm_io/channels.h"
#include "lcm_io/conversions.h"
#include "lcm_io/mono_map.h"
#include "marks/mark_keeper.h"
#include "path_publisher.h"
#include "pose_fusion.h"

namespace rubble::fusion {

namespace {

using common::Utime;
using lcm_io::NodeStatus;

constexpr Utime kCommandPeriod = common::kMicrosecondsPerSecond / 100;
constexpr Utime kCommandValid = common::kMicrosecondsPerSecond / 10;
constexpr Utime kControlPeriod = common::kMicrosecondsPerSecond / 20;
constexpr Utime kScalePeriod = common::kMicrosecondsPerSecond / 12;
constexpr Utime kPathPeriod = common::kMicrosecondsPerSecond;
constexpr Utime kStatePeriod = common::kMicrosecondsPerSecond / 2;
constexpr double kVisionStarts = 1.0;  // m of driving, after which it should have
/// Silence of the LiDAR that HEALTH tells.
constexpr Utime kLidarSilence = common::kMicrosecondsPerSecond / 2;
/// Silence of MONO_POSE after which the state is published without pictures, and how often.
constexpr Utime kMonoSilence = common::kMicrosecondsPerSecond / 10;
constexpr Utime kBlindPeriod = common::kMicrosecondsPerSecond / 30;
/// A picture that seems to be later than this is of a log.
constexpr Utime kLatest = common::kMicrosecondsPerSecond;
/// How long a contradiction is reported.
constexpr Utime kContradictionSpan = 10 * common::kMicrosecondsPerSecond;

class FusionNode : public lcm_io::Node {
 public:
  explicit FusionNode(const lcm_io::ProcessContext& context)
      : bus_(context.bus),
        times_(context.times),
        config_(context.config.read<FusionConfig>("fusion")),
        robot_(context.config.read<common::RobotConfig>("robot")),
        fusion_(config_, robot_),
        keeper_(bus_, config_.marks, robot_, fusion_, keyframes_) {
    bus_.subscribe<rubble::mono_pose_t>(lcm_io::channel::kMonoPose, [this](const auto& m) { onMonoPose(m); });
    bus_.subscribe<rubble::mono_map_t>(lcm_io::channel::kMonoMap, [this](const auto& m) { onMonoMap(m); });
    bus_.subscribe<rubble::lidar_pose_t>(lcm_io::channel::kLidarPose,
                                         [this](const auto& m) { onLidarPose(m); });
    bus_.subscribe<rubble::stabilizer_t>(lcm_io::channel::kStabilizer,
                                         [this](const auto& m) { onStabilizer(m); });
    if (!context.state_dir.empty()) {
      std::filesystem::create_directories(context.state_dir);
      const std::filesystem::path path = context.state_dir / "fusion.checkpoint";
      restoreFresh(path);
      checkpoint_.emplace(path);
    }
  }

  void advance(Utime bus_now) override {
    if (!started_) {
      return;
    }
    const Utime now = bus_now + log_offset_;
    if (now - last_mono_ >= kMonoSilence && now - last_state_.utime >= kBlindPeriod) {
      ++counters_.blind;
      publish(fusion_.advance(now));
    }
    if (now - last_control_ >= kControlPeriod) {
      publishControl(now);
    }
    if (now - last_command_ >= kCommandPeriod) {
      publishCommand(now);
    }
    if (checkpoint_ && now - last_checkpoint_ >= common::utimeFromSeconds(config_.checkpoint_period)) {
      checkpoint_->submit(serialise(memory()));
      last_checkpoint_ = now;
    }
  }

  void finish() override {
    if (checkpoint_ && started_) {
      checkpoint_->submit(serialise(memory()));
    }
  }

  NodeStatus status() const override {
    NodeStatus status;
    status.counters = {{"poses", counters_.poses},
                       {"poses_without_vision", counters_.blind},
                       {"switches", counters_.switches},
                       {"contradictions", contradicted_},
                       {"alignments", counters_.alignments},
                       {"sightings", keeper_.sightings()},
                       {"sightings_without_pose", keeper_.misses()},
                       {"marks", static_cast<std::int64_t>(keeper_.marks().marks().size())}};
    if (!started_) {
      status.state = "waiting";
      status.level = NodeStatus::Level::kDegraded;
      status.detail = "no MONO_POSE yet: is rubble-slam-mono running?";
      return status;
    }
    status.state = std::string(1, "HMR"[static_cast<int>(fusion_.plane().state())]);
    const Utime now = last_state_.utime;
    const bool vision = fusion_.visionTracks();
    const auto alignment = fusion_.alignment();
    std::string& detail = status.detail;
    const auto say = [&](const std::string& what) { detail += (detail.empty() ? "" : "; ") + what; };
    const bool h = fusion_.plane().state() == ControlState::kH;
    if (now - last_mono_ >= kMonoSilence) {
      say("MONO_POSE is silent: is the camera running?");
    } else if (fusion_.visionAstray()) {
      say("vision turns otherwise than the LiDAR and is not believed: the LiDAR alone carries the pose");
    } else if (!vision && !h) {
      say("vision is lost off the level: nothing carries the pose");
    } else if (!vision && vision_started_) {
      say("vision is lost: the LiDAR alone carries the pose, on flat ground");
    } else if (!vision && last_state_.T_world_body.translation().norm() > kVisionStarts) {
      say("vision has not started: the LiDAR alone carries the pose, on flat ground; show the camera "
          "texture");
    }
    if (lidar_poses_ == 0) {
      say("no LIDAR_POSE yet: is rubble-slam-lidar running? position has no scale");
    } else if (h && now - fusion_.lastLidar() > kLidarSilence) {
      say("no matched LIDAR_POSE: vision alone carries the pose");
    }
    if (!last_state_.attitude_known) {
      say("the attitude is unknown since vision was lost on a slope; nothing is written into the map");
    }
    if (vision && alignment && !alignment->scale_known && lidar_poses_ > 0 && counters_.poses > 300) {
      say("the monocular map's scale is unknown until the robot has moved on flat ground");
    }
    if (last_contradiction_ > 0 && now - last_contradiction_ <= kContradictionSpan) {
      say("LiDAR and vision contradicted each other: a slope's foot, or a wrong calibration in robot.yaml");
    }
    if (const std::string complaint = fusion_.complaint(); !complaint.empty()) {
      say(complaint);
    }
    if (const std::string error = checkpoint_ ? checkpoint_->error() : std::string(); !error.empty()) {
      say(fmt::format("checkpoint: {}", error));
    }
    if (!detail.empty()) {
      status.level = NodeStatus::Level::kDegraded;
    }
    return status;
  }

 private:
  struct Counters {
    std::int64_t poses = 0, blind = 0, switches = 0, alignments = 0;
  };

  FusionMemory memory() const {
    FusionMemory memory = fusion_.memory();
    memory.marks = keeper_.marks().marks();
    memory.next_mark_id = keeper_.marks().nextId();
    return memory;
  }

  /// Goes on from a checkpoint that is young enough.
  void restoreFresh(const std::filesystem::path& path) {
    const auto age = common::fileAge(path, bus_.now());
    if (!age) {
      return;
    }
    if (*age > config_.restore_within) {
      spdlog::info("{} is {:.0f} s old: not restored, world begins anew", path.string(), *age);
      return;
    }
    try {
      const FusionMemory memory = parseFusionMemory(common::readFile(path));
      fusion_.restore(memory);
      keeper_.restore(memory);
      vision_started_ = true;
      noted_revision_ = fusion_.plane().revision();
      spdlog::info("restored from {}, {:.0f} s old", path.string(), *age);
    } catch (const common::Error& e) {
      spdlog::error("{}: not restored, world begins anew: {}", path.string(), e.what());
    }
  }

  void onStabilizer(const rubble::stabilizer_t& m) {
    if (!std::isfinite(m.roll) || !std::isfinite(m.pitch)) {
      throw common::Error("plate angles that are not finite");
    }
    fusion_.addPlate(m.utime, m.roll, m.pitch);
  }

  void onMonoPose(const rubble::mono_pose_t& m) {
    const lcm_io::StageTimer timer(times_, "total");
    MonoMeasurement mono;
    mono.utime = m.utime;
    mono.tracking = m.state == rubble::mono_pose_t::STATE_TRACKING;
    mono.map_id = m.map_id;
    mono.map_revision = m.map_revision;
    if (mono.tracking) {
      mono.T_mono_camera = lcm_io::poseFromMessage(m.p_mono_camera, m.q_mono_camera);
    }
    started_ = true;
    vision_started_ = vision_started_ || mono.tracking;
    last_mono_ = m.utime;
    // A log that is played live has its own time.
    const Utime late = bus_.now() - m.utime;
    log_offset_ = std::abs(late) < kLatest ? 0 : -late;
    counters_.blind += mono.tracking ? 0 : 1;
    publish(fusion_.addMono(mono));
    measureScale(mono);
  }

  void onMonoMap(const rubble::mono_map_t& m) {
    const lcm_io::StageTimer timer(times_, "alignment");
    const auto pictures = lcm_io::readMonoMap(m, keyframes_);
    fusion_.addPictures(pictures, keyframes_, m.revision);
    keeper_.addPictures(pictures, m.revision);
    ++counters_.alignments;
    for (const rubble::mono_map_point_t& point : m.points) {
      points_.set(point.id, point.map_id,
                  Eigen::Map<const Eigen::Vector3f>(point.p_mono_point).cast<double>());
    }
    for (const std::int64_t id : m.erased_points) {
      points_.erase(id);
    }
  }

  void measureScale(const MonoMeasurement& mono) {
    if (config_.plane.mode != "joint" || !mono.tracking || mono.utime - last_scale_ < kScalePeriod) {
      return;
    }
    // The beams ahead are in the middle of the sweep.
    const Utime middle = common::utimeFromSeconds(0.5 * robot_.lidar_sweep_time_s);
    const RangeScan* scan = keeper_.scanAt(mono.utime - middle);
    if (scan == nullptr) {
      return;
    }
    const auto known = fusion_.scaleOf(mono.map_id);
    const auto measured = points_.measure(mono.map_id, mono.T_mono_camera, fusion_.T_camera_lidar(mono.utime),
                                          *scan, known ? std::optional(std::log(*known)) : std::nullopt);
    if (measured) {
      fusion_.addScale(mono.utime, *measured);
    }
    last_scale_ = mono.utime;
  }

  void onLidarPose(const rubble::lidar_pose_t& m) {
    const Eigen::Matrix3d covariance = Eigen::Map<const Eigen::Matrix3d>(m.covariance);
    if (!std::isfinite(m.x) || !std::isfinite(m.y) || !std::isfinite(m.yaw) || !covariance.allFinite()) {
      throw common::Error("a pose that is not finite");
    }
    if (covariance.ldlt().vectorD().minCoeff() < 0.0) {
      throw common::Error("a covariance that is not positive semidefinite");
    }
    ++lidar_poses_;
    LidarMeasurement lidar;
    lidar.utime = m.utime;
    lidar.T_world_lidar = {m.x, m.y, m.yaw};
    lidar.covariance = covariance;
    lidar.good = m.status == rubble::lidar_pose_t::STATUS_GOOD;
    lidar.revision = m.control_revision;
    lidar.tilt_guessed = (m.flags & rubble::lidar_pose_t::FLAG_ATTITUDE_EXTRAPOLATED) != 0;
    const ControlState before = fusion_.plane().state();
    fusion_.addLidar(lidar);
    if (fusion_.plane().state() != before) {
      noteState(m.utime);
    }
  }

  void noteState(Utime utime) {
    if (fusion_.plane().contradicted() != contradicted_) {
      contradicted_ = fusion_.plane().contradicted();
      last_contradiction_ = utime;
    }
    if (started_) {
      spdlog::info("control state {} on level {}, floor at {:.2f} m",
                   "HMR"[static_cast<int>(fusion_.plane().state())], fusion_.plane().levelId(),
                   fusion_.plane().level().floor);
      counters_.switches += fusion_.plane().state() == ControlState::kM ? 1 : 0;
      publishControl(utime);
      publishFusionState(utime);
    }
    noted_revision_ = fusion_.plane().revision();
  }

  void publish(const RobotState& state) {
    last_state_ = state;
    ++counters_.poses;
    rubble::robot_pose_t pose;
    pose.utime = state.utime;
    lcm_io::poseToMessage(state.T_world_body, pose.p_world_body, pose.q_world_body);
    Eigen::Map<Eigen::Vector3d>(pose.v_world_body) = state.v_world_body;
    Eigen::Map<Eigen::Vector3d>(pose.w_body) = state.w_body;
    Eigen::Map<Eigen::Matrix<double, 6, 6>>(pose.covariance) = state.covariance;
    pose.attitude =
        state.attitude_known ? rubble::robot_pose_t::ATTITUDE_KNOWN : rubble::robot_pose_t::ATTITUDE_UNKNOWN;
    pose.control_state = static_cast<std::int8_t>(fusion_.plane().state());
    pose.level = fusion_.plane().levelId();
    bus_.publish(lcm_io::channel::kRobotPose, pose);
    path_.add(pose);
    keeper_.addState(state, fusion_.plane().levelId());
    keeper_.publish(state.utime);
    if (state.utime - last_path_ >= kPathPeriod) {
      bus_.publish(lcm_io::channel::kTrajectory, path_.next(state.utime));
      last_path_ = state.utime;
    }
    publishControl(state.utime);
    if (fusion_.plane().revision() != noted_revision_) {
      noteState(state.utime);
    } else if (state.utime - last_fusion_state_ >= kStatePeriod) {
      publishFusionState(state.utime);
    }
  }

  void publishControl(Utime utime) {
    rubble::lidar_control_t control;
    control.utime = utime;
    control.revision = fusion_.plane().revision();
    control.state = static_cast<std::int8_t>(fusion_.plane().state());
    control.level = fusion_.plane().levelId();
    control.confirmed_h_utime = fusion_.plane().confirmed();
    bus_.publish(lcm_io::channel::kLidarControl, control);
    last_control_ = utime;
  }

  void publishFusionState(Utime utime) {
    rubble::fusion_state_t state{};
    state.utime = utime;
    state.control_state = static_cast<std::int8_t>(fusion_.plane().state());
    state.level = fusion_.plane().levelId();
    state.map_id = fusion_.mapId();
    state.map_revision = fusion_.mapRevision();
    common::Pose3 T_world_mono = common::Pose3::Identity();
    if (const auto alignment = fusion_.alignment()) {
      state.scale_known = alignment->scale_known ? 1 : 0;
      state.scale = alignment->S_world_mono.scale;
      state.scale_sigma = alignment->scale_sigma;
      T_world_mono.linear() = alignment->S_world_mono.R;
      T_world_mono.translation() = alignment->S_world_mono.p;
    }
    lcm_io::poseToMessage(T_world_mono, state.p_world_mono, state.q_world_mono);
    bus_.publish(lcm_io::channel::kFusionState, state);
    last_fusion_state_ = utime;
  }

  /// Set-points that run ahead of the attitude by as much as the servos lag behind them.
  void publishCommand(Utime now) {
    rubble::stabilizer_command_t command;
    command.utime = now;
    command.valid_until_utime = now + kCommandValid;
    const Utime answered = now + common::utimeFromSeconds(config_.servo_lead);
    const PlateAngles angles = fusion_.levelling(answered);
    const PlateAngles before = fusion_.levelling(answered - kCommandPeriod);
    const double rate = 1.0 / common::secondsFromUtime(kCommandPeriod);
    command.roll = angles.roll;
    command.pitch = angles.pitch;
    command.roll_rate = rate * (angles.roll - before.roll);
    command.pitch_rate = rate * (angles.pitch - before.pitch);
    bus_.publish(lcm_io::channel::kStabilizerCommand, command);
    last_command_ = std::max(last_command_ + kCommandPeriod, now - kCommandPeriod);
  }

  lcm_io::Bus& bus_;
  lcm_io::StageTimes* times_;
  const FusionConfig config_;
  const common::RobotConfig robot_;
  PoseFusion fusion_;
  common::KeyframePoses keyframes_;
  MarkKeeper keeper_;
  PointScale points_;
  PathPublisher path_;
  std::optional<common::CheckpointWriter> checkpoint_;

  bool started_ = false;
  RobotState last_state_;
  std::int64_t lidar_poses_ = 0;
  std::int64_t noted_revision_ = 0;
  int contradicted_ = 0;
  Utime last_contradiction_ = 0;
  Utime log_offset_ = 0;  // From the bus's time to the data's.
  Utime last_mono_ = 0;
  Utime last_scale_ = 0;
  bool vision_started_ = false;  // By this process, or by the one whose checkpoint it restored.
  Utime last_control_ = 0;
  Utime last_command_ = 0;
  Utime last_fusion_state_ = 0;
  Utime last_path_ = 0;
  Utime last_checkpoint_ = 0;
  Counters counters_;
};

}  // namespace

std::unique_ptr<lcm_io::Node> makeNode(const lcm_io::ProcessContext& context) {
  return std::make_unique<FusionNode>(context);
}

std::string describeConfig(const common::Config& config) {
  return config.describe<common::RobotConfig>("robot") + config.describe<FusionConfig>("fusion");
}

}  // namespace rubble::fusion
