#include "scene/ray_tracer.h"

#include <fmt/format.h>

#include <cmath>
#include <cstring>

#include "common/error.h"

namespace rubble::arena_sim {

namespace {

void addGeometry(RTCDevice device, RTCScene scene, unsigned id, const Surface& surface) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), surface.vertices.size()));
  for (const Surface::Vertex& vertex : surface.vertices) {
    std::memcpy(vertices, vertex.p_world.data(), 3 * sizeof(float));
    vertices += 3;
  }
  void* triangles = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                            3 * sizeof(std::uint32_t), surface.triangles.size());
  std::memcpy(triangles, surface.triangles.data(), surface.triangles.size() * 3 * sizeof(std::uint32_t));
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(scene, geometry, id);
  rtcReleaseGeometry(geometry);
}

}  // namespace

RayTracer::RayTracer(const Scene& scene, const std::function<bool(const Surface&)>& wanted)
    : device_(rtcNewDevice("threads=1")), scene_(device_ ? rtcNewScene(device_.get()) : nullptr) {
  if (!scene_) {
    throw common::Error(
        fmt::format("Embree does not start (error {})", static_cast<int>(rtcGetDeviceError(nullptr))));
  }
  // A single builder thread and no compaction: the same scene gives the same tree.
  rtcSetSceneFlags(scene_.get(), RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneBuildQuality(scene_.get(), RTC_BUILD_QUALITY_HIGH);
  for (std::size_t i = 0; i < scene.surfaces.size(); ++i) {
    if (!wanted || wanted(scene.surfaces[i])) {
      addGeometry(device_.get(), scene_.get(), static_cast<unsigned>(i), scene.surfaces[i]);
    }
  }
  rtcCommitScene(scene_.get());
}

std::optional<RayTracer::Hit> RayTracer::cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                                              double max_distance) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRayHit ray{};
  const Eigen::Vector3f o = origin.cast<float>();
  const Eigen::Vector3f d = direction.cast<float>();
  ray.ray.org_x = o.x();
  ray.ray.org_y = o.y();
  ray.ray.org_z = o.z();
  ray.ray.dir_x = d.x();
  ray.ray.dir_y = d.y();
  ray.ray.dir_z = d.z();
  ray.ray.tfar = static_cast<float>(max_distance);
  ray.ray.mask = 0xffffffffU;
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(scene_.get(), &context, &ray);
  if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) {
    return std::nullopt;
  }
  const Eigen::Vector3f normal(ray.hit.Ng_x, ray.hit.Ng_y, ray.hit.Ng_z);
  return Hit{static_cast<double>(ray.ray.tfar), ray.hit.geomID, ray.hit.primID,
             static_cast<double>(std::abs(normal.normalized().dot(d)))};
}

}  // namespace rubble::arena_sim
