#include "samples/doll_studio.h"

#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "scene/canvas.h"
#include "scene/mesh.h"
#include "scene/victim.h"
#include "sensors/camera_model.h"

namespace rubble::arena_sim {

namespace {

using Eigen::Vector3d;

constexpr int kPixels = 208;                 // Of a square picture; its lens has no distortion.
constexpr double kFocalPerDistance = 250.0;  // px/m: dolls are as large from anywhere.
constexpr double kCentre = 0.5 * (kPixels - 1);
constexpr double kLookAt = 0.1;  // m, height over the ground.
/// What it lies on, as in a box: from below, the edge hides a part.
const Vector3d kBoard(0.74, 0.5, 0.02);
constexpr std::uint8_t kFloorGrey = 150;
constexpr int kRays = 3;  // Per pixel and axis.
constexpr std::uint64_t kStream = 50;

common::RobotConfig::Intrinsics studioLens(double focal) {
  common::RobotConfig::Intrinsics lens;
  lens.width = lens.height = kPixels;
  lens.focal = {focal, focal};
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

/// Floor and walls, so that the camera's exposure is for more than the doll.
void addRoom(const Appearance& look, std::vector<Surface>* surfaces) {
  constexpr double kSide = 5.0;  // m
  constexpr double kFloor = -0.42;
  const common::Pose3 floor(Eigen::Translation3d(0.0, 0.0, kFloor));
  surfaces->push_back(makePicture(floor, {kSide, kSide}, look));
  for (int wall = 0; wall < 4; ++wall) {
    const common::Pose3 T =
        common::Pose3(Eigen::AngleAxisd(0.5 * wall * std::numbers::pi, Vector3d::UnitZ())) *
        Eigen::Translation3d(0.0, 0.5 * kSide, kFloor + 0.5 * kSide) *
        Eigen::AngleAxisd(0.5 * std::numbers::pi, Vector3d::UnitX());
    surfaces->push_back(makePicture(T, {kSide, kSide}, look));
  }
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
  doll_surfaces_ = surfaces.size();
  Appearance grey;
  grey.picture = std::make_shared<const cv::Mat>(8, 8, CV_8UC3, cv::Scalar::all(kFloorGrey));
  addBox(surfaces, common::Pose3(Eigen::Translation3d(0.0, 0.0, -0.5 * kBoard.z())), kBoard, grey, false);
  addRoom(grey, &surfaces);
  Dice dice(seed, kStream);
  for (const double side : {-1.0, 1.0}) {
    const double ahead = static_cast<double>(dice.uniform(-1.5F, 1.5F));
    const double power = static_cast<double>(dice.uniform(3.0F, 14.0F));
    scene_->lamps.push_back({{ahead, side * 1.5, 3.0}, {0.7, 0.4}, power, 0});
  }
  tracer_ = std::make_shared<const RayTracer>(*scene_);
}

cv::Mat DollStudio::portrait(const Viewpoint& view) const {
  const common::Pose3 T_world_camera = cameraAt(view);
  const double focal = kFocalPerDistance * std::hypot(view.distance, view.height - kLookAt);
  CameraModel camera(studioCamera(), studioLens(focal), scene_, tracer_, 1);
  const cv::Mat bgr = camera.take(0.0, [&](double) { return T_world_camera; }).bgr;
  const cv::Mat alpha = coverage(T_world_camera, focal);
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
cv::Mat DollStudio::coverage(const common::Pose3& T_world_camera, double focal) const {
  cv::Mat alpha(kPixels, kPixels, CV_8UC1);
  for (int y = 0; y < kPixels; ++y) {
    for (int x = 0; x < kPixels; ++x) {
      int hits = 0;
      for (int ray = 0; ray < kRays * kRays; ++ray) {
        const double u = x - 0.5 + (ray % kRays + 0.5) / kRays;
        const double v = y - 0.5 + (ray / kRays + 0.5) / kRays;
        const Vector3d direction = Vector3d((u - kCentre) / focal, (v - kCentre) / focal, 1.0).normalized();
        const auto hit = tracer_->cast(T_world_camera.translation(), T_world_camera.linear() * direction);
        hits += hit && hit->surface < doll_surfaces_ ? 1 : 0;
      }
      alpha.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(255 * hits / (kRays * kRays));
    }
  }
  return alpha;
}

}  // namespace rubble::arena_sim
