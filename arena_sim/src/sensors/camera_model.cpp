#include "sensors/camera_model.h"

#include <optional>

#include "sensors/exposure.h"
#include "sensors/image_sensor.h"
#include "sensors/lens.h"
#include "sensors/light_bake.h"
#include "sensors/light_change.h"
#include "sensors/ray_table.h"
#include "sensors/renderer.h"
#include "sensors/shutter.h"
#include "sensors/texture_set.h"
#include "sensors/worker_pool.h"

namespace rubble::arena_sim {

namespace {

/// Blue, green, red: the hall's lamps are colder than the work lights; the white balance lies between.
const Eigen::Array4f kLampColours[kLampGroups] = {{1.04F, 1.0F, 0.97F, 0.0F}, {0.88F, 1.0F, 1.08F, 0.0F}};

std::vector<float> meanReflectances(const std::vector<Texture>& textures) {
  std::vector<float> means;
  means.reserve(textures.size());
  for (const Texture& texture : textures) {
    means.push_back(texture.meanReflectance());
  }
  return means;
}

double meanGrey(const cv::Mat& bgr) {
  const cv::Scalar mean = cv::mean(bgr);
  return (mean[0] + mean[1] + mean[2]) / 3.0;
}

}  // namespace

struct CameraModel::Parts {
  Parts(const CameraModelConfig& config_in, const common::RobotConfig::Intrinsics& intrinsics,
        const Scene& scene, std::shared_ptr<const RayTracer> tracer_in, std::uint64_t seed_in,
        unsigned threads)
      : config(config_in),
        seed(seed_in),
        tracer(std::move(tracer_in)),
        rays(Lens(intrinsics), intrinsics.width, intrinsics.height),
        sensor(intrinsics, config.vignetting, config.noise, config.contrast, seed),
        light_change(config.light_change, seed),
        auto_exposure(config.exposure, config.gain_limit),
        workers(threads),
        textures(paintTextures(scene, 1e6 * config.texture_budget, workers)),
        renderer(scene, tracer->embree(), textures,
                 bakeLight(scene, tracer->embree(), meanReflectances(textures), workers), rays,
                 config.samples),
        radiance(intrinsics.width, intrinsics.height) {}

  const CameraModelConfig config;
  const std::uint64_t seed;
  const std::shared_ptr<const RayTracer> tracer;
  const RayTable rays;
  const ImageSensor sensor;
  const LightChange light_change;
  AutoExposure auto_exposure;
  WorkerPool workers;
  const std::vector<Texture> textures;
  const Renderer renderer;
  Radiance radiance;
  std::uint64_t frame = 0;
  std::optional<double> last_s;
  double last_grey = 0.0;

  LightLevels lightLevels(double seconds, double lights) const {
    LightLevels levels;
    for (int group = 0; group < kLampGroups; ++group) {
      levels.group[group] =
          kLampColours[group] * static_cast<float>(lights * light_change.brightness(group, seconds));
    }
    levels.headlight = static_cast<float>(lights * config.headlight);
    return levels;
  }

  CameraPicture expose(double seconds, const PoseAt& T_world_camera, double lights) {
    const Exposure exposure = auto_exposure.exposure();
    const Shutter shutter(seconds, exposure.seconds, config.readout, radiance.height, config.samples,
                          T_world_camera);
    renderer.render(shutter, lightLevels(seconds, lights), hashOf(seed) + frame, workers, radiance);
    CameraPicture picture{sensor.develop(radiance, exposure, frame, workers), exposure.seconds,
                          exposure.gain};
    last_grey = meanGrey(picture.bgr);
    return picture;
  }

  /// Before its first picture the camera has looked at the scene for a while.
  void settle(double seconds, const PoseAt& T_world_camera) {
    constexpr int kLooks = 5;
    constexpr double kLong = 10.0;  // s
    for (int i = 0; i < kLooks; ++i) {
      expose(seconds, T_world_camera, 1.0);
      auto_exposure.follow(last_grey, kLong);
    }
  }
};

CameraModel::CameraModel(const CameraModelConfig& config, const common::RobotConfig::Intrinsics& intrinsics,
                         const std::shared_ptr<const Scene>& scene, std::shared_ptr<const RayTracer> tracer,
                         std::uint64_t seed, unsigned threads)
    : parts_(std::make_unique<Parts>(config, intrinsics, *scene, std::move(tracer), seed, threads)) {}

CameraModel::~CameraModel() = default;

CameraPicture CameraModel::take(double seconds, const PoseAt& T_world_camera, double lights) {
  if (parts_->last_s) {
    parts_->auto_exposure.follow(parts_->last_grey, seconds - *parts_->last_s);
  } else {
    parts_->settle(seconds, T_world_camera);
  }
  parts_->last_s = seconds;
  CameraPicture picture = parts_->expose(seconds, T_world_camera, lights);
  ++parts_->frame;
  return picture;
}

void visit(common::ConfigSection& section, CameraModelConfig& config) {
  section.integer("samples", config.samples, "", 1, 64, "rays per pixel, spread over pixel and exposure");
  section.number("exposure", config.exposure, "s", 1e-4, 0.1, "longest; shorter in bright light");
  section.number("gain_limit", config.gain_limit, "", 1.0, 64.0, "largest gain once the exposure is longest");
  section.number("readout", config.readout, "s", 0.0, 0.1, "first row to last; 0 is a global shutter");
  section.number("vignetting", config.vignetting, "", 0.0, 2.0,
                 "darker towards the corners; 1 is the fourth power of the cosine");
  section.number("noise", config.noise, "", 0.0, 5.0, "shot and read noise; 1 is a small, cheap sensor");
  section.number("contrast", config.contrast, "", 0.5, 3.0,
                 "steepness of the tone curve in the middle; 1 is plain sRGB, cameras set more");
  section.number("headlight", config.headlight, "", 0.0, 100.0, "the robot's lamp, irradiance at 1 m");
  section.number("light_change", config.light_change, "", 0.0, 2.0,
                 "how much the lamps' brightness drifts and jumps, as a share");
  section.number("texture_budget", config.texture_budget, "million texels", 0.1, 1000.0,
                 "of all textures together, 5.4 MB each; more than needed is not painted");
  section.integer("jpeg_quality", config.jpeg_quality, "", 10, 100, "of the pictures sent");
}

}  // namespace rubble::arena_sim
