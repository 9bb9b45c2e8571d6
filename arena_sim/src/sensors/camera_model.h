#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <thread>

#include "common/config.h"
#include "common/robot_config.h"
#include "scene/ray_tracer.h"
#include "scene/scene.h"
#include "sensors/pose_at.h"

namespace rubble::arena_sim {

/// How the camera turns light into pictures; units in visit(). Geometry and lens are in `robot.camera`.
struct CameraModelConfig {
  int samples = 4;
  double exposure = 0.008;
  double gain_limit = 8.0;
  double readout = 0.0;
  double vignetting = 0.6;
  double noise = 1.0;
  double contrast = 1.5;
  double headlight = 0.05;
  double light_change = 0.3;
  double texture_budget = 100.0;
  int jpeg_quality = 90;
};

void visit(common::ConfigSection& section, CameraModelConfig& config);

struct CameraPicture {
  cv::Mat bgr;  // 8UC3
  double exposure_s = 0.0;
  double gain = 1.0;
};

/// The camera in its scene: textures and light are baked once, then pictures are rendered one after the
/// other on all cores. The same calls in the same order give the same pictures, on any number of threads.
class CameraModel {
 public:
  /// `tracer` holds all surfaces of `scene`.
  CameraModel(const CameraModelConfig& config, const common::RobotConfig::Intrinsics& intrinsics,
              const std::shared_ptr<const Scene>& scene, std::shared_ptr<const RayTracer> tracer,
              std::uint64_t seed, unsigned threads = std::thread::hardware_concurrency());
  ~CameraModel();

  /// The picture whose exposure (of the middle row) is centred on `seconds`, later than that of the last one.
  /// T_world_camera is asked for times (s) within exposure and readout around it. `lights`: what the lamps
  /// give of their light.
  CameraPicture take(double seconds, const PoseAt& T_world_camera, double lights = 1.0);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace rubble::arena_sim
