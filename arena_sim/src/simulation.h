#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <rubble/revisit_request_t.hpp>
#include <rubble/stabilizer_command_t.hpp>
#include <string>
#include <vector>

#include "common/robot_config.h"
#include "common/time.h"
#include "config.h"
#include "lcm_io/codec.h"
#include "motion/motion.h"
#include "scene/ray_tracer.h"
#include "sensors/lens.h"
#include "truth/truth_recorder.h"
#include "world/world.h"

namespace rubble::arena_sim {

/// The robot driving through its world: sensor reports one after the other, as messages on the drivers'
/// channels. The plate follows what commandPlate() was told, the robot goes back where revisit() asks it to;
/// who calls them in between step() closes the loop.
class Simulation {
 public:
  using Publish = std::function<void(common::Utime received, const char* channel, const lcm_io::Bytes& data)>;
  using Watch = std::function<void(double seconds, const cv::Mat& bgr)>;

  struct Sensors {
    bool camera = true;
    bool odometry = true;
  };

  /// `watch` sees every picture as it goes out. Throws common::Error for what cannot be simulated.
  Simulation(const World& world, const Motion& motion, const ArenaSimConfig& config,
             const common::RobotConfig& robot, std::uint64_t seed, Sensors sensors, Publish publish,
             Watch watch);

  /// The next report in the order of arrival; false when the drive is over.
  bool step();
  double seconds() const { return seconds_; }

  void commandPlate(const PlateCommand& command) { stabilizer_.command(command); }
  void commandPlate(const rubble::stabilizer_command_t& command);
  /// The robot backs up along its own way to the oldest of the keyframes, then drives on as planned. Until
  /// then further requests are not heard.
  void revisit(const rubble::revisit_request_t& request);

  const Motion& motion() const { return motion_; }
  const TruthRecorder& truth() const { return truth_; }

 private:
  /// A sensor that reports with a fixed period.
  struct Source {
    double rate = 0.0;
    double first = 0.0;    // Stamp of the first report, s.
    double delay_s = 0.0;  // From the stamp to the arrival.
    std::function<void(double seconds, common::Utime received)> report;
    int reports = 0;

    double stamp() const { return first + reports / rate; }
    double arrival() const { return stamp() + delay_s; }
  };

  template <typename Message>
  void publish(common::Utime received, const char* channel, double seconds, const Message& message);
  common::Utime stampOf(const char* channel, double seconds) const;
  common::Pose3 T_world_lidar(double seconds) const;
  common::Pose3 T_world_camera(double seconds) const;

  void reportCameraInfo(double seconds, common::Utime received);
  void reportPicture(double seconds, common::Utime received);
  void reportScan(double seconds, common::Utime received);
  void reportStabilizer(double seconds, common::Utime received);
  void reportOdometry(double seconds, common::Utime received);
  void reportTruth(double seconds, common::Utime received, const char* frame,
                   const common::Pose3& T_world_frame);

  const ArenaSimConfig config_;
  const common::RobotConfig robot_;
  const Publish publish_;
  const Watch watch_;
  Disturbances disturbances_;
  Motion motion_;
  double retraced_until_ = 0.0;  // s
  std::shared_ptr<const Scene> scene_;
  std::shared_ptr<const RayTracer> tracer_;
  std::optional<CameraModel> camera_;
  StabilizerModel stabilizer_;
  LidarModel lidar_;
  OdometryModel odometry_;
  TruthRecorder truth_;
  std::vector<Source> sources_;
  double seconds_ = 0.0;
};

}  // namespace rubble::arena_sim
