#include "arena_sim/mission.h"

#include <fmt/format.h>

#include <algorithm>
#include <bot_core/planar_lidar_t.hpp>
#include <cmath>
#include <functional>
#include <rubble/ground_truth_t.hpp>
#include <rubble/odometry_t.hpp>
#include <rubble/stabilizer_t.hpp>
#include <vector>

#include "arena_sim_config.h"
#include "common/error.h"
#include "common/files.h"
#include "common/robot_config.h"
#include "common/trajectory.h"
#include "lcm_io/channels.h"
#include "lcm_io/conversions.h"
#include "lcm_io/log_file.h"
#include "route.h"
#include "top_view.h"
#include "truth_map.h"

namespace rubble::arena_sim {

namespace {

constexpr common::Utime kStartUtime = 1'700'000'000 * common::kMicrosecondsPerSecond;
constexpr common::Utime kTransport = 500;  // From a measurement's end to its arrival.
constexpr double kStabilizerRate = 50.0;
constexpr int kMapEveryScan = 4;
constexpr std::size_t kMapEveryBeam = 2;

common::Utime utimeOf(double seconds) { return kStartUtime + common::utimeFromSeconds(seconds); }

/// A sensor that reports with a fixed period.
struct Source {
  double rate = 0.0;
  double delay_s = 0.0;  // From the stamp to the arrival.
  std::function<void(double seconds, common::Utime received)> report;
  int reports = 0;

  double stamp() const { return reports / rate; }
  double arrival() const { return stamp() + delay_s; }
};

class Mission {
 public:
  Mission(const MissionOptions& options, const ArenaSimConfig& config, const common::RobotConfig& robot,
          const std::filesystem::path& out)
      : config_(config),
        T_body_lidar_(robot.T_body_lidar()),
        arena_(makeArena(options.seed)),
        caster_(arena_.segments),
        motion_(planRoute(arena_, options.seed, options.duration_s, config.motion)),
        lidar_(config.lidar, caster_, motion_, planar(T_body_lidar_), robot.lidar_sweep_time_s, options.seed),
        odometry_(config.odometry, motion_, options.seed),
        map_(arena_.segments),
        log_(out / "mission.lcm"),
        out_(out) {
    sources_ = {{kStabilizerRate, 0.0, [this](double t, common::Utime r) { reportStabilizer(t, r); }},
                {config.lidar.rate, robot.lidar_sweep_time_s,
                 [this](double t, common::Utime r) { reportScan(t, r); }}};
    if (options.with_odometry) {
      sources_.push_back(
          {config.odometry.rate, 0.0, [this](double t, common::Utime r) { reportOdometry(t, r); }});
    }
    run(options.duration_s);
  }

 private:
  static common::Pose2 planar(const common::Pose3& T) {
    const common::RollPitchYaw rpy = common::rpyFromRotation(T.linear());
    constexpr double kLevel = 1e-6;
    if (std::abs(rpy.roll) > kLevel || std::abs(rpy.pitch) > kLevel) {
      throw common::Error(
          "the mission `flat` needs a level LiDAR: roll and pitch of robot.lidar.rpy must be 0");
    }
    return {T.translation().x(), T.translation().y(), rpy.yaw};
  }

  /// All reports in the order of their arrival, then the files of truth.
  void run(double duration_s) {
    while (true) {
      Source& next =
          *std::min_element(sources_.begin(), sources_.end(),
                            [](const Source& a, const Source& b) { return a.arrival() < b.arrival(); });
      if (next.arrival() >= duration_s) {
        break;
      }
      next.report(next.stamp(), utimeOf(next.arrival()) + kTransport);
      ++next.reports;
    }
    log_.close();
    const std::filesystem::path truth = out_ / "truth";
    std::filesystem::create_directories(truth);
    common::writeTum(truth / "body.tum", body_truth_);
    common::writeTum(truth / "lidar.tum", lidar_truth_);
    common::writeFileAtomically(truth / "map_0.pgm", map_.pgm());
    common::writeFileAtomically(truth / "map_0.yaml", map_.yaml("map_0.pgm"));
    writeTopView(out_ / "top_view.png", arena_, map_, motion_);
  }

  void reportScan(double seconds, common::Utime received) {
    bot_core::planar_lidar_t scan;
    scan.utime = utimeOf(seconds);
    scan.ranges = lidar_.measure(seconds);
    scan.nranges = static_cast<std::int32_t>(scan.ranges.size());
    scan.nintensities = 0;
    scan.rad0 = static_cast<float>(config_.lidar.firstAngle());
    scan.radstep = static_cast<float>(config_.lidar.angleStep());
    log_.writeMessage(received, lcm_io::channel::kScan, scan);

    const common::Pose3 T_world_body = common::pose3FromPose2(motion_.at(seconds));
    reportTruth(scan.utime, received, "body", T_world_body, body_truth_);
    reportTruth(scan.utime, received, "lidar", T_world_body * T_body_lidar_, lidar_truth_);
    if (scans_++ % kMapEveryScan == 0) {
      seeMap(seconds);
    }
  }

  /// Seen in one moment is near enough: the map shows what the mission saw, not how.
  void seeMap(double seconds) {
    const common::Pose2 T_world_lidar = lidar_.pose(seconds);
    const int beams = config_.lidar.beams;
    for (int i = 0; i < beams; i += kMapEveryBeam) {
      const double angle = T_world_lidar.yaw + config_.lidar.firstAngle() + i * config_.lidar.angleStep();
      const Eigen::Vector2d direction(std::cos(angle), std::sin(angle));
      const double range = caster_.cast(T_world_lidar.translation(), direction);
      if (range <= config_.lidar.max_range) {
        map_.addBeam(T_world_lidar.translation(), T_world_lidar.translation() + range * direction);
      }
    }
  }

  void reportTruth(common::Utime utime, common::Utime received, const char* frame,
                   const common::Pose3& T_world_frame, common::Trajectory& trajectory) {
    rubble::ground_truth_t truth;
    truth.utime = utime;
    truth.frame = frame;
    lcm_io::poseToMessage(T_world_frame, truth.p_world_frame, truth.q_world_frame);
    log_.writeMessage(received, lcm_io::channel::kGroundTruth, truth);
    trajectory.push_back({utime, T_world_frame});
  }

  void reportStabilizer(double seconds, common::Utime received) {
    rubble::stabilizer_t stabilizer{};
    stabilizer.utime = utimeOf(seconds);
    log_.writeMessage(received, lcm_io::channel::kStabilizer, stabilizer);
  }

  void reportOdometry(double seconds, common::Utime received) {
    rubble::odometry_t odometry;
    odometry.utime = utimeOf(seconds);
    lcm_io::poseToMessage(common::pose3FromPose2(odometry_.next()), odometry.p_odom_body,
                          odometry.q_odom_body);
    log_.writeMessage(received, lcm_io::channel::kOdometry, odometry);
  }

  const ArenaSimConfig config_;
  const common::Pose3 T_body_lidar_;
  const Arena arena_;
  const RayCaster caster_;
  const Motion motion_;
  LidarModel lidar_;
  OdometryModel odometry_;
  TruthMap map_;
  lcm_io::LogWriter log_;
  const std::filesystem::path out_;
  std::vector<Source> sources_;
  common::Trajectory body_truth_;
  common::Trajectory lidar_truth_;
  int scans_ = 0;
};

}  // namespace

common::RobotConfig arenaRobot() {
  common::RobotConfig robot;
  robot.plate_translation = {0.10, 0.0, 0.25};
  robot.lidar_sweep_time_s = 0.01875;
  return robot;
}

void writeFlatMission(const MissionOptions& options, const common::Config& config,
                      const std::filesystem::path& out) {
  if (!(options.duration_s >= kShortestMission)) {
    throw common::Error(fmt::format("a mission of {} s is too short; give it at least {} s",
                                    options.duration_s, kShortestMission));
  }
  std::error_code error;
  std::filesystem::create_directories(out, error);
  if (error) {
    throw common::Error(fmt::format("{}: cannot be created ({})", out.string(), error.message()));
  }
  const auto robot = config.read<common::RobotConfig>("robot", arenaRobot());
  Mission(options, config.read<ArenaSimConfig>("arena_sim"), robot, out);
  common::writeFileAtomically(out / "robot.yaml",
                              config.describe<common::RobotConfig>("robot", arenaRobot()));
}

}  // namespace rubble::arena_sim
