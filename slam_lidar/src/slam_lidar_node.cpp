#include "slam_lidar/slam_lidar_node.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <bot_core/planar_lidar_t.hpp>
#include <cmath>
#include <deque>
#include <filesystem>
#include <optional>
#include <rubble/command_t.hpp>
#include <rubble/lidar_control_t.hpp>
#include <rubble/lidar_pose_t.hpp>
#include <rubble/odometry_t.hpp>
#include <rubble/robot_pose_t.hpp>
#include <rubble/stabilizer_t.hpp>
#include <utility>

#include "common/checkpoint_writer.h"
#include "common/error.h"
#include "common/files.h"
#include "common/robot_config.h"
#include "lcm_io/channels.h"
#include "lcm_io/conversions.h"
#include "level_grids.h"
#include "scan_context.h"
#include "slam_lidar/grid_slam.h"
#include "slam_lidar_config.h"

namespace rubble::slam_lidar {

namespace {

using common::Utime;
using lcm_io::Node;
using lcm_io::NodeStatus;
using rubble::lidar_control_t;
using rubble::lidar_pose_t;

/// Search window (m, rad) around the last pose after a restart: the robot may have moved on meanwhile.
constexpr double kRestoreDistance = 3.0;
constexpr double kRestoreAngle = 3.15;
/// So long a new level's grid is written by the fused motion, which is truer than a match with a few scans.
constexpr Utime kBeginning = common::kMicrosecondsPerSecond;
/// Scans that wait for their attitude at the same time; more mean that time stands still.
constexpr std::size_t kMostWaiting = 100;

SlamLidarConfig readConfig(const common::Config& config) {
  SlamLidarConfig slam = config.read<SlamLidarConfig>("slam_lidar");
  const auto robot = config.read<common::RobotConfig>("robot");
  slam.grid.scan.sweep_duration = robot.lidar_sweep_time_s;
  slam.grid.scan.height_above_floor = robot.lidarHeight();
  return slam;
}

/// The robot starts level at the origin of world.
common::Pose2 startPose(const common::Config& config) {
  const common::Pose3 T_world_lidar = config.read<common::RobotConfig>("robot").T_body_lidar();
  return {T_world_lidar.translation().x(), T_world_lidar.translation().y(),
          common::rpyFromRotation(T_world_lidar.linear()).yaw};
}

/// The grids of a checkpoint that is young enough, searching around the last pose; empty where there is none.
std::optional<LevelGrids> restoreFresh(const std::filesystem::path& path, const SlamLidarConfig& config,
                                       Utime now) {
  const auto age = common::fileAge(path, now);
  if (!age) {
    return std::nullopt;
  }
  if (*age > config.restore_within) {
    spdlog::info("{} is {:.0f} s old: not restored, a new map begins", path.string(), *age);
    return std::nullopt;
  }
  try {
    LevelGrids grids = LevelGrids::restore(config.grid, common::readFile(path));
    grids.present().relocalise(grids.present().pose(), kRestoreDistance, kRestoreAngle);
    spdlog::info("restored from {}, {:.0f} s old", path.string(), *age);
    return grids;
  } catch (const common::Error& e) {
    spdlog::error("{}: not restored, a new map begins: {}", path.string(), e.what());
    return std::nullopt;
  }
}

class SlamLidarNode : public Node {
 public:
  explicit SlamLidarNode(const lcm_io::ProcessContext& context)
      : bus_(context.bus),
        times_(context.times),
        config_(readConfig(context.config)),
        context_(context.config.read<common::RobotConfig>("robot")),
        grids_(config_.grid, startPose(context.config)) {
    if (!context.state_dir.empty()) {
      std::filesystem::create_directories(context.state_dir);
      const std::filesystem::path path = context.state_dir / "slam_lidar.checkpoint";
      if (auto restored = restoreFresh(path, config_, bus_.now())) {
        grids_ = std::move(*restored);
      }
      checkpoint_.emplace(path);
    }
    subscribe();
  }

  void advance(Utime now) override {
    now_ = now;
    const auto due = [&](const Waiting& scan) {
      return now >= scan.deadline || context_.complete(scan.message.utime, endOfSweep(scan.message));
    };
    handleWaiting(due);
  }

  void finish() override {
    handleWaiting([](const Waiting&) { return true; });
    for (const rubble::grid_map_t& map : grids_.remainingMaps(last_scan_utime_)) {
      bus_.publish(lcm_io::channel::kGridMap, map);
    }
    if (checkpoint_ && counters_.scans > 0) {
      checkpoint_->submit(grids_.serialise());
    }
  }

  NodeStatus status() const override {
    NodeStatus status;
    status.counters = {{"scans", counters_.scans},
                       {"scans_written", counters_.written},
                       {"scans_uncertain", counters_.uncertain},
                       {"scans_lost", counters_.lost},
                       {"searches_local", counters_.searches_local},
                       {"searches_wide", counters_.searches_wide},
                       {"attitude_extrapolated", counters_.extrapolated}};
    if (counters_.scans == 0) {
      status.state = "waiting";
    } else if (control_ && controlSilent()) {
      status.state = "unconfirmed";
      status.level = NodeStatus::Level::kDegraded;
      status.detail = "LIDAR_CONTROL is silent: nothing is written into the map; is rubble-fusion running?";
    } else if (last_status_ == lidar_pose_t::STATUS_LOST) {
      status.state = "lost";
      status.level = NodeStatus::Level::kDegraded;
      status.detail = "the scans do not fit the map: searching, nothing is written";
    } else {
      status.state = last_status_ == lidar_pose_t::STATUS_UNMATCHED ? "suspended" : "tracking";
    }
    if (const std::string error = checkpoint_ ? checkpoint_->error() : std::string(); !error.empty()) {
      status.level = NodeStatus::Level::kDegraded;
      status.detail += (status.detail.empty() ? "" : "; ") + fmt::format("checkpoint: {}", error);
    }
    return status;
  }

 private:
  struct Waiting {
    bot_core::planar_lidar_t message;
    Utime deadline = 0;
  };

  struct Counters {
    std::int64_t scans = 0, written = 0, uncertain = 0, lost = 0;
    std::int64_t searches_local = 0, searches_wide = 0, extrapolated = 0;
  };

  void subscribe() {
    bus_.subscribe<bot_core::planar_lidar_t>(lcm_io::channel::kScan, [this](const auto& m) { onScan(m); });
    bus_.subscribe<rubble::stabilizer_t>(
        lcm_io::channel::kStabilizer, [this](const auto& m) { context_.addPlate(m.utime, m.roll, m.pitch); });
    bus_.subscribe<rubble::robot_pose_t>(lcm_io::channel::kRobotPose, [this](const auto& m) {
      context_.addBody(m.utime, lcm_io::poseFromMessage(m.p_world_body, m.q_world_body));
    });
    bus_.subscribe<lidar_control_t>(lcm_io::channel::kLidarControl, [this](const auto& m) { onControl(m); });
    bus_.subscribe<rubble::command_t>(lcm_io::channel::kCommand, [this](const auto& m) { onCommand(m); });
    if (config_.use_odometry) {
      bus_.subscribe<rubble::odometry_t>(lcm_io::channel::kOdometry, [this](const auto& m) {
        context_.addOdometry(m.utime, lcm_io::poseFromMessage(m.p_odom_body, m.q_odom_body));
      });
    }
  }

  void onScan(const bot_core::planar_lidar_t& message) {
    if (!std::isfinite(message.rad0) || !(std::abs(message.radstep) > 1e-6F)) {
      throw common::Error(fmt::format("scan with rad0 = {} and radstep = {}", message.rad0, message.radstep));
    }
    if (waiting_.size() >= kMostWaiting) {
      throw common::Error(
          fmt::format("{} scans wait for their attitude: the bus's time stands still", kMostWaiting));
    }
    const Utime now = std::max(now_, bus_.now());
    waiting_.push_back({message, now + common::utimeFromSeconds(config_.attitude_wait)});
  }

  void onControl(const lidar_control_t& control) {
    if (control.state < lidar_control_t::STATE_H || control.state > lidar_control_t::STATE_R) {
      throw common::Error(fmt::format("unknown state {}", control.state));
    }
    if (control.level < 0 || control.level >= LevelGrids::kMostLevels) {
      throw common::Error(fmt::format("level {} is impossible: they are 0 to {}", control.level,
                                      LevelGrids::kMostLevels - 1));
    }
    const bool other_level = control.level != grids_.level();
    const bool news = !control_ || control.state != control_->state || control.level != control_->level;
    if (news) {
      spdlog::info("control state {} on level {}", "HMR"[control.state], control.level);
    }
    if (grids_.knows(control.level) && (other_level || (news && control.state == lidar_control_t::STATE_R))) {
      grids_.enter(control.level);
    }
    control_ = control;
    control_received_ = bus_.now();
    if (!other_level) {
      grids_.present().commitUntil(control.confirmed_h_utime);
    }
    if (control.state == lidar_control_t::STATE_M) {
      grids_.present().discardPending(control.confirmed_h_utime + 1);
    }
  }

  void onCommand(const rubble::command_t& command) {
    if (command.target != "slam_lidar") {
      return;
    }
    if (command.verb == "save") {
      common::writeFileAtomically(command.argument, grids_.serialise());
    } else if (command.verb == "load") {
      grids_ = LevelGrids::restore(config_.grid, common::readFile(command.argument));
    } else {
      throw common::Error(fmt::format("unknown command `{}`; known: save FILE, load FILE", command.verb));
    }
    spdlog::info("{} {}", command.verb, command.argument);
  }

  bool controlSilent() const {
    return bus_.now() - control_received_ > common::utimeFromSeconds(config_.control_timeout);
  }

  Utime endOfSweep(const bot_core::planar_lidar_t& scan) const {
    return scan.utime + common::utimeFromSeconds(config_.grid.scan.sweep_duration);
  }

  ScanMode scanMode(Utime utime) const {
    if (!control_) {
      return ScanMode::kMatchAndWrite;
    }
    if (control_->level != grids_.level()) {
      return ScanMode::kIgnore;  // Its grid has not begun.
    }
    switch (control_->state) {
      case lidar_control_t::STATE_M:
        return ScanMode::kIgnore;
      case lidar_control_t::STATE_R:
        return ScanMode::kMatchOnly;
      default:
        if (utime < written_until_ && !controlSilent()) {
          return ScanMode::kWriteOnly;
        }
        return controlSilent() ? ScanMode::kMatchOnly : ScanMode::kMatchAndWrite;
    }
  }

  template <typename Due>
  void handleWaiting(const Due& due) {
    while (!waiting_.empty() && due(waiting_.front())) {
      const Waiting scan = std::move(waiting_.front());
      waiting_.pop_front();
      handle(scan.message);
    }
  }

  void handle(const bot_core::planar_lidar_t& message) {
    match(message);
    if (message.utime - last_map_utime_ >= common::utimeFromSeconds(config_.map_period)) {
      const lcm_io::StageTimer publish(times_, "publish_map");
      for (const rubble::grid_map_t& map : grids_.nextMaps(message.utime)) {
        bus_.publish(lcm_io::channel::kGridMap, map);
      }
      last_map_utime_ = message.utime;
    }
    if (checkpoint_ && bus_.now() - last_checkpoint_ >= common::utimeFromSeconds(config_.checkpoint_period)) {
      checkpoint_->submit(grids_.serialise());
      last_checkpoint_ = bus_.now();
    }
  }

  /// The grid of a level that LIDAR_CONTROL has named and nobody has seen.
  bool beginLevel(Utime utime) {
    if (!control_ || grids_.knows(control_->level) || control_->state == lidar_control_t::STATE_M) {
      return false;
    }
    const auto T_world_lidar = context_.fusedPose(utime);
    if (T_world_lidar) {
      grids_.begin(control_->level, *T_world_lidar, context_.heightAt(utime));
      written_until_ = utime + kBeginning;
    }
    return T_world_lidar.has_value();
  }

  void match(const bot_core::planar_lidar_t& message) {
    const lcm_io::StageTimer total(times_, "total");
    const bool begins = beginLevel(message.utime);
    const ScanContext::Tilt first = context_.tiltAt(message.utime);
    const ScanContext::Tilt last = context_.tiltAt(endOfSweep(message));
    ScanInput input;
    input.scan = {message.utime, static_cast<double>(message.rad0), static_cast<double>(message.radstep),
                  std::span(message.ranges)};
    input.attitude_first = first.attitude;
    input.attitude_last = last.attitude;
    input.height = context_.heightAt(message.utime) - grids_.floor();
    input.attitude_extrapolated = first.extrapolated || last.extrapolated;
    input.mode = scanMode(message.utime);
    const bool unmatched = input.mode == ScanMode::kIgnore || input.mode == ScanMode::kWriteOnly;
    input.prior = context_.takePrior(message.utime, unmatched ? ScanContext::PriorSource::kFusedPose
                                                              : ScanContext::PriorSource::kOdometry);
    if (begins) {
      input.prior.reset();  // It begins at this very scan.
    }
    input.hold_write = control_.has_value();

    ScanResult result;
    try {
      const lcm_io::StageTimer timer(times_, "match");
      result = grids_.present().addScan(input);
    } catch (const common::Error& e) {
      bus_.refuse(lcm_io::channel::kScan, e.what());
      return;
    }
    count(result, input);
    publishPose(result, input);
  }

  void count(const ScanResult& result, const ScanInput& input) {
    last_scan_utime_ = result.utime;
    ++counters_.scans;
    counters_.written += result.written || result.pending ? 1 : 0;
    counters_.extrapolated += input.attitude_extrapolated ? 1 : 0;
    counters_.searches_local += result.search == SearchKind::kLocal ? 1 : 0;
    counters_.searches_wide += result.search == SearchKind::kWide ? 1 : 0;
    if (input.mode == ScanMode::kIgnore) {
      last_status_ = lidar_pose_t::STATUS_UNMATCHED;
    } else if (result.status == MatchStatus::kGood) {
      last_status_ = lidar_pose_t::STATUS_GOOD;
    } else if (result.status == MatchStatus::kUncertain) {
      last_status_ = lidar_pose_t::STATUS_UNCERTAIN;
      ++counters_.uncertain;
    } else {
      last_status_ = lidar_pose_t::STATUS_LOST;
      ++counters_.lost;
    }
  }

  void publishPose(const ScanResult& result, const ScanInput& input) {
    lidar_pose_t pose;
    pose.utime = result.utime;
    pose.x = result.T_world_lidar.x;
    pose.y = result.T_world_lidar.y;
    pose.yaw = result.T_world_lidar.yaw;
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) {
        pose.covariance[3 * row + column] = result.covariance(row, column);
      }
    }
    pose.score = result.score;
    pose.status = last_status_;
    pose.flags = static_cast<std::int8_t>(
        (result.written || result.pending ? lidar_pose_t::FLAG_WRITTEN : 0) |
        (input.attitude_extrapolated ? lidar_pose_t::FLAG_ATTITUDE_EXTRAPOLATED : 0) |
        (input.prior ? lidar_pose_t::FLAG_PRIOR_USED : 0));
    pose.control_state = control_ ? control_->state : lidar_control_t::STATE_H;
    pose.control_revision = control_ ? control_->revision : -1;
    pose.level = grids_.level();
    pose.map_revision = static_cast<std::int64_t>(grids_.present().mapRevision());
    bus_.publish(lcm_io::channel::kLidarPose, pose);
  }

  lcm_io::Bus& bus_;
  lcm_io::StageTimes* times_;
  const SlamLidarConfig config_;
  ScanContext context_;
  LevelGrids grids_;
  std::optional<common::CheckpointWriter> checkpoint_;

  std::deque<Waiting> waiting_;
  Utime now_ = 0;

  std::optional<lidar_control_t> control_;
  Utime control_received_ = 0;
  Utime written_until_ = 0;

  Counters counters_;
  std::int8_t last_status_ = lidar_pose_t::STATUS_LOST;
  Utime last_scan_utime_ = 0;
  Utime last_map_utime_ = 0;
  Utime last_checkpoint_ = 0;
};

}  // namespace

std::unique_ptr<Node> makeNode(const lcm_io::ProcessContext& context) {
  return std::make_unique<SlamLidarNode>(context);
}

std::string describeConfig(const common::Config& config) {
  return config.describe<common::RobotConfig>("robot") + config.describe<SlamLidarConfig>("slam_lidar");
}

}  // namespace rubble::slam_lidar
