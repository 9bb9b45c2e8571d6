#include "simulation.h"

#include <fmt/format.h>

#include <algorithm>
#include <bot_core/image_t.hpp>
#include <bot_core/planar_lidar_t.hpp>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <rubble/camera_info_t.hpp>
#include <rubble/ground_truth_t.hpp>
#include <rubble/odometry_t.hpp>
#include <rubble/stabilizer_t.hpp>
#include <utility>

#include "common/error.h"
#include "lcm_io/channels.h"
#include "lcm_io/conversions.h"
#include "lcm_io/pixel_format.h"
#include "motion/retrace.h"

namespace rubble::arena_sim {

namespace {

constexpr common::Utime kStartUtime = 1'700'000'000 * common::kMicrosecondsPerSecond;
constexpr common::Utime kTransport = 500;     // From a report's end to its arrival.
constexpr double kPictureProcessing = 0.010;  // s, compressing.

/// Streams of random numbers; the world and the route have 0 to 9.
enum Stream : std::uint32_t { kStabilizerStream = 10, kLidarStream, kOdometryStream, kDisturbanceStream };

common::Utime utimeOf(double seconds) { return kStartUtime + common::utimeFromSeconds(seconds); }
double secondsOf(common::Utime utime) { return common::secondsFromUtime(utime - kStartUtime); }

}  // namespace

Simulation::Simulation(const World& world, const Motion& motion, const ArenaSimConfig& config,
                       const common::RobotConfig& robot, std::uint64_t seed, Sensors sensors, Publish publish,
                       Watch watch)
    : config_(config),
      robot_(robot),
      publish_(std::move(publish)),
      watch_(std::move(watch)),
      disturbances_(config.disturbances, motion.duration(), randomStream(seed, kDisturbanceStream)),
      motion_(disturbances_.disturb(motion)),
      scene_(std::make_shared<Scene>(world.scene)),
      tracer_(std::make_shared<RayTracer>(*scene_)),
      stabilizer_(config.stabilizer, randomStream(seed, kStabilizerStream)),
      lidar_(
          config.lidar, robot.lidar_sweep_time_s, *scene_, *tracer_,
          [this](double t) { return T_world_lidar(t); }, randomStream(seed, kLidarStream)),
      odometry_(
          config.odometry, [this](double t) { return motion_.at(t); }, randomStream(seed, kOdometryStream)),
      truth_(config.truth, world, *tracer_, robot.lidarHeight()) {
  const auto add = [this](double rate, double first, double delay_s,
                          void (Simulation::*report)(double, common::Utime)) {
    sources_.push_back(
        {rate, first, delay_s, [this, report](double t, common::Utime r) { (this->*report)(t, r); }});
  };
  add(config.stabilizer.rate, 0.0, 0.0, &Simulation::reportStabilizer);
  add(config.lidar.rate, 0.0, robot.lidar_sweep_time_s, &Simulation::reportScan);
  if (sensors.odometry) {
    add(config.odometry.rate, 0.0, 0.0, &Simulation::reportOdometry);
  }
  if (sensors.camera) {
    camera_.emplace(config.camera, robot.intrinsics, scene_, tracer_, seed);
    const double rate = robot.intrinsics.rate;
    const double delay = 0.5 * (config.camera.exposure + config.camera.readout) + kPictureProcessing;
    add(5.0, 0.0, 0.0, &Simulation::reportCameraInfo);
    add(rate, 0.5 / rate, delay, &Simulation::reportPicture);
  }
}

bool Simulation::step() {
  Source& next = *std::min_element(sources_.begin(), sources_.end(), [](const Source& a, const Source& b) {
    return a.arrival() < b.arrival();
  });
  if (next.arrival() >= motion_.duration()) {
    return false;
  }
  seconds_ = next.arrival();
  stabilizer_.advance(seconds_);
  next.report(next.stamp(), utimeOf(seconds_) + kTransport);
  ++next.reports;
  return true;
}

void Simulation::commandPlate(const rubble::stabilizer_command_t& command) {
  commandPlate({secondsOf(command.utime),
                {command.roll, command.pitch},
                {command.roll_rate, command.pitch_rate},
                secondsOf(command.valid_until_utime)});
}

void Simulation::revisit(const rubble::revisit_request_t& request) {
  if (request.keyframes.empty() || seconds_ < retraced_until_) {
    return;
  }
  const auto oldest = std::min_element(request.keyframes.begin(), request.keyframes.end(),
                                       [](const auto& a, const auto& b) { return a.utime < b.utime; });
  Retrace way = retrace(motion_, seconds_, std::max(0.0, secondsOf(oldest->utime)));
  motion_ = std::move(way.motion);
  retraced_until_ = way.end;
}

template <typename Message>
void Simulation::publish(common::Utime received, const char* channel, double seconds,
                         const Message& message) {
  for (int i = disturbances_.copies(channel, seconds); i > 0; --i) {
    publish_(received, channel, lcm_io::encode(message));
  }
}

common::Utime Simulation::stampOf(const char* channel, double seconds) const {
  return utimeOf(seconds + disturbances_.clockOffset(channel, seconds));
}

common::Pose3 Simulation::T_world_lidar(double seconds) const {
  const PlateAngles plate = stabilizer_.at(seconds);
  return motion_.at(seconds) * robot_.T_body_plate(plate.roll, plate.pitch) * robot_.lidar.pose();
}

common::Pose3 Simulation::T_world_camera(double seconds) const {
  return motion_.at(seconds) * robot_.T_body_camera();
}

void Simulation::reportCameraInfo(double seconds, common::Utime received) {
  rubble::camera_info_t info;
  info.utime = utimeOf(seconds);
  lcm_io::intrinsicsToMessage(robot_.intrinsics, info);
  publish(received, lcm_io::channel::kCameraInfo, seconds, info);
}

void Simulation::reportPicture(double seconds, common::Utime received) {
  CameraPicture picture = camera_->take(
      seconds, [this](double t) { return T_world_camera(t); }, disturbances_.isBlackout(seconds) ? 0.0 : 1.0);
  disturbances_.occlude(seconds, picture.bgr);
  if (watch_) {
    watch_(seconds, picture.bgr);
  }
  bot_core::image_t image;
  image.utime = stampOf(lcm_io::channel::kCamera, seconds);
  image.width = picture.bgr.cols;
  image.height = picture.bgr.rows;
  image.row_stride = 0;
  image.pixelformat = lcm_io::kMjpg;
  RUBBLE_CHECK(
      cv::imencode(".jpg", picture.bgr, image.data, {cv::IMWRITE_JPEG_QUALITY, config_.camera.jpeg_quality}));
  image.size = static_cast<std::int32_t>(image.data.size());
  const std::string exposure = fmt::format("{}", std::lround(picture.exposure_s * 1e6));
  image.metadata.resize(1);
  image.metadata[0].key = "exposure_us";
  image.metadata[0].value.assign(exposure.begin(), exposure.end());
  image.metadata[0].n = static_cast<std::int32_t>(exposure.size());
  image.nmetadata = 1;
  publish(received, lcm_io::channel::kCamera, seconds, image);

  const common::Pose3 T_world_body = motion_.at(seconds);
  reportTruth(seconds, received, "body", T_world_body);
  reportTruth(seconds, received, "camera", T_world_camera(seconds));
  truth_.addPicture(utimeOf(seconds), T_world_body, T_world_camera(seconds));
}

void Simulation::reportScan(double seconds, common::Utime received) {
  bot_core::planar_lidar_t scan;
  scan.utime = stampOf(lcm_io::channel::kScan, seconds);
  scan.ranges = lidar_.measure(seconds);
  scan.nranges = static_cast<std::int32_t>(scan.ranges.size());
  scan.nintensities = 0;
  scan.rad0 = static_cast<float>(config_.lidar.firstAngle());
  scan.radstep = static_cast<float>(config_.lidar.angleStep());
  publish(received, lcm_io::channel::kScan, seconds, scan);

  const common::Pose3 T_world_body = motion_.at(seconds);
  reportTruth(seconds, received, "body", T_world_body);
  reportTruth(seconds, received, "lidar", T_world_lidar(seconds));
  truth_.addScan(utimeOf(seconds), T_world_body, T_world_lidar(seconds));
}

void Simulation::reportTruth(double seconds, common::Utime received, const char* frame,
                             const common::Pose3& T_world_frame) {
  rubble::ground_truth_t truth;
  truth.utime = utimeOf(seconds);
  truth.frame = frame;
  lcm_io::poseToMessage(T_world_frame, truth.p_world_frame, truth.q_world_frame);
  publish(received, lcm_io::channel::kGroundTruth, seconds, truth);
}

void Simulation::reportStabilizer(double seconds, common::Utime received) {
  const PlateAngles angles = stabilizer_.read(seconds);
  const PlateAngles rates = stabilizer_.ratesAt(seconds);
  rubble::stabilizer_t stabilizer;
  stabilizer.utime = stampOf(lcm_io::channel::kStabilizer, seconds);
  stabilizer.roll = angles.roll;
  stabilizer.pitch = angles.pitch;
  stabilizer.roll_rate = rates.roll;
  stabilizer.pitch_rate = rates.pitch;
  const double following = stabilizer_.following();
  stabilizer.command_utime = following >= 0.0 ? utimeOf(following) : 0;
  publish(received, lcm_io::channel::kStabilizer, seconds, stabilizer);
}

void Simulation::reportOdometry(double seconds, common::Utime received) {
  rubble::odometry_t odometry;
  odometry.utime = stampOf(lcm_io::channel::kOdometry, seconds);
  lcm_io::poseToMessage(common::pose3FromPose2(odometry_.next()), odometry.p_odom_body, odometry.q_odom_body);
  publish(received, lcm_io::channel::kOdometry, seconds, odometry);
}

}  // namespace rubble::arena_sim
