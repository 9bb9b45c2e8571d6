#include "samples/doll_studio.h"

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "scene/mesh.h"
#include "scene/victim.h"
#include "sensors/camera_model.h"

namespace rubble::arena_sim {

namespace {

using Eigen::Vector3d;

constexpr int kPixels = 320;  // Of a square picture; its lens has no distortion.
constexpr double kFocal = 480.0;
constexpr double kCentre = 0.5 * (kPixels - 1);
constexpr double kLookAt = 0.1;  // m, height over the ground.
constexpr std::uint8_t kFloorGrey = 150;
constexpr int kRays = 3;  // Per pixel and axis.

common::RobotConfig::Intrinsics studioLens() {
  common::RobotConfig::Intrinsics lens;
  lens.width = lens.height = kPixels;
  lens.focal = {kFocal, kFocal};
  lens.centre = {kCentre, kCentre};
  return lens;
}

CameraModelConfig studioCamera() {
  CameraModelConfig config;
  config.samples = 16;
  config.vignetting = 0.0;
  config.noise = 0.0;
  config.light_change = 0.0;
  config.texture_budget = 1.0;
  return config;
}

common::Pose3 cameraAt(const Viewpoint& view) {
  const Vector3d p(view.distance * std::cos(view.azimuth), view.distance * std::sin(view.azimuth),
                   view.height);
  const Vector3d forward = (Vector3d(0.0, 0.0, kLookAt) - p).normalized();
  const Vector3d right = forward.cross(Vector3d::UnitZ()).normalized();
  common::Pose3 T = common::Pose3::Identity();
  T.linear() << right, forward.cross(right), forward;
  T.translation() = p;
  return T;
}

}  // namespace

DollStudio::DollStudio(std::uint64_t seed) : scene_(std::make_shared<Scene>()) {
  std::vector<Surface>& surfaces = scene_->surfaces;
  addVictim(surfaces, common::Pose3::Identity(), seed);
  std::erase_if(surfaces,
                [](const Surface& surface) { return surface.appearance.material == Material::kCardboard; });
  doll_ = std::make_unique<RayTracer>(*scene_);
  Appearance floor;
  floor.picture = std::make_shared<const cv::Mat>(8, 8, CV_8UC3, cv::Scalar::all(kFloorGrey));
  constexpr double kFloor = 8.0;
  surfaces.push_back(makePicture(common::Pose3::Identity(), {kFloor, kFloor}, floor));
  for (const double side : {-1.0, 1.0}) {
    scene_->lamps.push_back({{0.5, side * 1.5, 3.0}, {0.7, 0.4}, 10.0, 0});
  }
}

cv::Mat DollStudio::portrait(const Viewpoint& view) const {
  const common::Pose3 T_world_camera = cameraAt(view);
  CameraModel camera(studioCamera(), studioLens(), scene_, std::make_shared<const RayTracer>(*scene_), 1);
  const cv::Mat bgr = camera.take(0.0, [&](double) { return T_world_camera; }).bgr;
  const cv::Mat alpha = coverage(T_world_camera);
  std::vector<cv::Mat> channels;
  cv::split(bgr, channels);
  for (cv::Mat& channel : channels) {
    channel.setTo(kFloorGrey, alpha == 0);
  }
  channels.push_back(alpha);
  cv::Mat picture;
  cv::merge(channels, picture);
  constexpr int kMargin = 3;
  cv::Rect box = cv::boundingRect(alpha);
  box -= cv::Point(kMargin, kMargin);
  box += cv::Size(2 * kMargin, 2 * kMargin);
  return picture(box & cv::Rect(0, 0, kPixels, kPixels)).clone();
}

/// How much of each pixel the doll fills, 0 .. 255.
cv::Mat DollStudio::coverage(const common::Pose3& T_world_camera) const {
  cv::Mat alpha(kPixels, kPixels, CV_8UC1);
  for (int y = 0; y < kPixels; ++y) {
    for (int x = 0; x < kPixels; ++x) {
      int hits = 0;
      for (int ray = 0; ray < kRays * kRays; ++ray) {
        const double u = x - 0.5 + (ray % kRays + 0.5) / kRays;
        const double v = y - 0.5 + (ray / kRays + 0.5) / kRays;
        const Vector3d direction = Vector3d((u - kCentre) / kFocal, (v - kCentre) / kFocal, 1.0).normalized();
        hits += doll_->cast(T_world_camera.translation(), T_world_camera.linear() * direction) ? 1 : 0;
      }
      alpha.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(255 * hits / (kRays * kRays));
    }
  }
  return alpha;
}

}  // namespace rubble::arena_sim
