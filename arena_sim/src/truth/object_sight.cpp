#include "truth/object_sight.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace rubble::arena_sim {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kNearest = 0.05;  // m before the camera
constexpr double kLargestIncidence = 70.0 / 180.0 * std::numbers::pi;
constexpr double kFreePicture = 0.9;
constexpr double kFreeVictim = 0.6;
constexpr int kGrid = 5;                // Rays along each side of the object's box.
constexpr double kRayTolerance = 0.01;  // m

bool isFlat(const WorldObject& object) { return object.bounds.sizes().z() == 0.0; }

/// Of a picture: around its outline; of a box: all eight.
std::vector<Vector3d> cornersOf(const WorldObject& object) {
  const Vector3d& low = object.bounds.min();
  const Vector3d& high = object.bounds.max();
  std::vector<Vector3d> corners;
  const std::array heights = {low.z(), high.z()};
  for (std::size_t i = 0; i < (isFlat(object) ? 1 : heights.size()); ++i) {
    corners.insert(corners.end(), {{low.x(), low.y(), heights[i]},
                                   {high.x(), low.y(), heights[i]},
                                   {high.x(), high.y(), heights[i]},
                                   {low.x(), high.y(), heights[i]}});
  }
  return corners;
}

double meanSide(const std::vector<Vector2d>& outline) {
  double product = 1.0;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    product *= (outline[(i + 1) % outline.size()] - outline[i]).norm();
  }
  return std::pow(product, 1.0 / static_cast<double>(outline.size()));
}

double meanExtent(const std::vector<Vector2d>& pixels) {
  Eigen::AlignedBox2d box;
  for (const Vector2d& pixel : pixels) {
    box.extend(pixel);
  }
  return std::sqrt(box.volume());
}

/// Distance along a unit ray to where it enters the box, for rays that meet it.
double entryDistance(const Eigen::AlignedBox3d& box, const Vector3d& origin, const Vector3d& direction) {
  double entry = 0.0;
  for (Eigen::Index i = 0; i < 3; ++i) {
    if (direction[i] != 0.0) {
      const double a = (box.min()[i] - origin[i]) / direction[i];
      const double b = (box.max()[i] - origin[i]) / direction[i];
      entry = std::max(entry, std::min(a, b));
    }
  }
  return entry;
}

}  // namespace

ObjectSight::ObjectSight(const Scene& scene, const common::RobotConfig::Intrinsics& intrinsics)
    : intrinsics_(intrinsics), lens_(intrinsics), tracer_(scene) {}

std::optional<double> ObjectSight::sizeOf(const WorldObject& object,
                                          const common::Pose3& T_world_camera) const {
  const common::Pose3 T_camera_object = T_world_camera.inverse() * object.T_world_object;
  const Vector3d centre = T_camera_object.translation();
  if (isFlat(object) &&
      -centre.dot(T_camera_object.linear().col(2)) < centre.norm() * std::cos(kLargestIncidence)) {
    return std::nullopt;
  }
  std::vector<Vector2d> pixels;
  for (const Vector3d& corner : cornersOf(object)) {
    const auto pixel = pixelOf(T_camera_object * corner);
    if (!pixel) {
      return std::nullopt;
    }
    pixels.push_back(*pixel);
  }
  if (freeShare(object, T_world_camera.translation()) < (isFlat(object) ? kFreePicture : kFreeVictim)) {
    return std::nullopt;
  }
  return isFlat(object) ? meanSide(pixels) : meanExtent(pixels);
}

std::optional<Vector2d> ObjectSight::pixelOf(const Vector3d& p_camera) const {
  if (p_camera.z() < kNearest) {
    return std::nullopt;
  }
  const Vector2d pixel = lens_.project(p_camera);
  const bool inside = pixel.minCoeff() >= -0.5 && pixel.x() <= intrinsics_.width - 0.5 &&
                      pixel.y() <= intrinsics_.height - 0.5;
  // Far outside of the picture the lens's polynomial may lead back into it.
  constexpr double kSameRay = 1e-4;
  if (!inside || (lens_.unproject(pixel) - p_camera.normalized()).norm() > kSameRay) {
    return std::nullopt;
  }
  return pixel;
}

double ObjectSight::freeShare(const WorldObject& object, const Vector3d& p_world_camera) const {
  const Vector3d p_object_camera = object.T_world_object.inverse() * p_world_camera;
  const int layers = isFlat(object) ? 1 : kGrid;
  int free = 0;
  for (int i = 0; i < kGrid * kGrid * layers; ++i) {
    const Vector3d cell = Vector3d(i % kGrid, i / kGrid % kGrid, i / (kGrid * kGrid)).array() + 0.5;
    const Vector3d share = cell.cwiseQuotient(Vector3d(kGrid, kGrid, layers));
    const Vector3d target = object.bounds.min() + share.cwiseProduct(object.bounds.sizes());
    const Vector3d direction = (target - p_object_camera).normalized();
    const double way = entryDistance(object.bounds, p_object_camera, direction) - kRayTolerance;
    const Vector3d ray = object.T_world_object.linear() * direction;
    free += way <= 0.0 || !tracer_.cast(p_world_camera, ray, way) ? 1 : 0;
  }
  return static_cast<double>(free) / (kGrid * kGrid * layers);
}

}  // namespace rubble::arena_sim
