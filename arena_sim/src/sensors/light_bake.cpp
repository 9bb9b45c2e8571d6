#include "sensors/light_bake.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace rubble::arena_sim {

namespace {

using Eigen::Vector3f;

constexpr int kLampSide = 4;            // Shadow rays per lamp: kLampSide^2.
constexpr int kGatherRays = 64;         // Of reflected light.
constexpr float kLift = 0.002F;         // m, off the surface
constexpr float kFarthestPull = 0.02F;  // m

/// Points of light on a surface: its vertices, drawn into it a little, lest one on an edge sits in the corner
/// of two boards.
std::vector<Vector3f> lightPoints(const Surface& surface) {
  std::vector<Vector3f> inner(surface.vertices.size(), Vector3f::Zero());
  std::vector<float> count(surface.vertices.size(), 0.0F);
  for (const auto& triangle : surface.triangles) {
    Vector3f centre = Vector3f::Zero();
    for (const std::uint32_t corner : triangle) {
      centre += surface.vertices[corner].p_world / 3.0F;
    }
    for (const std::uint32_t corner : triangle) {
      inner[corner] += centre;
      count[corner] += 1.0F;
    }
  }
  for (std::size_t i = 0; i < inner.size(); ++i) {
    const Surface::Vertex& vertex = surface.vertices[i];
    const Vector3f way = inner[i] / std::max(1.0F, count[i]) - vertex.p_world;
    const float pull = std::min(0.2F, kFarthestPull / std::max(way.norm(), 1e-6F));
    inner[i] = vertex.p_world + pull * way + kLift * vertex.normal;
  }
  return inner;
}

RTCRay makeRay(const Vector3f& origin, const Vector3f& direction, float length) {
  RTCRay ray{};
  ray.org_x = origin.x();
  ray.org_y = origin.y();
  ray.org_z = origin.z();
  ray.dir_x = direction.x();
  ray.dir_y = direction.y();
  ray.dir_z = direction.z();
  ray.tfar = length;
  ray.mask = 0xffffffffU;
  return ray;
}

bool isVisible(RTCScene tracer, const Vector3f& from, const Vector3f& to) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  constexpr float kShort = 0.995F;  // Of the lamp's own housing.
  RTCRay ray = makeRay(from, to - from, kShort);
  rtcOccluded1(tracer, &context, &ray);
  return ray.tfar >= 0.0F;
}

/// From one of the lamp's cells.
float cellLight(RTCScene tracer, const Lamp& lamp, int cell, const Vector3f& p, const Vector3f& normal) {
  const int row = cell / kLampSide;
  const auto share = [](int step) { return (2.0F * static_cast<float>(step) + 1.0F) / kLampSide - 1.0F; };
  const float u = share(cell % kLampSide);
  const float v = share(row);
  const Eigen::Vector2f half = lamp.half_size.cast<float>();
  const Vector3f light = lamp.p_world.cast<float>() + Vector3f(u * half.x(), v * half.y(), 0.0F);
  const Vector3f way = light - p;
  const float squared = way.squaredNorm();
  const float cosines = std::max(0.0F, way.z()) * std::max(0.0F, way.dot(normal)) / squared;
  if (cosines <= 0.0F || !isVisible(tracer, p, light)) {
    return 0.0F;
  }
  const float area = 4.0F * half.prod() / (kLampSide * kLampSide);
  return static_cast<float>(lamp.power) * area * cosines / squared;
}

Irradiance directLight(const Scene& scene, RTCScene tracer, const Vector3f& p, const Vector3f& normal) {
  Irradiance light{};
  for (const Lamp& lamp : scene.lamps) {
    for (int cell = 0; cell < kLampSide * kLampSide; ++cell) {
      light.at(lamp.group) += cellLight(tracer, lamp, cell, p, normal);
    }
  }
  return light;
}

/// The underside of a lamp's housing shines itself: as irradiance that a white surface would throw back.
Irradiance glow(const Scene& scene, const Surface::Vertex& vertex) {
  constexpr float kNear = 0.05F;  // m
  Irradiance light{};
  for (const Lamp& lamp : scene.lamps) {
    const Vector3f way = (vertex.p_world - lamp.p_world.cast<float>()).cwiseAbs();
    const Eigen::Vector2f half = lamp.half_size.cast<float>();
    if (vertex.normal.z() < -0.9F && way.x() < half.x() + kNear && way.y() < half.y() + kNear &&
        way.z() < kNear) {
      light.at(lamp.group) = std::numbers::pi_v<float> * static_cast<float>(lamp.power);
    }
  }
  return light;
}

/// Evenly over the cosine-weighted hemisphere about z, the same at every point: neighbours err alike, and the
/// light between them stays smooth.
std::array<Vector3f, kGatherRays> gatherDirections() {
  std::array<Vector3f, kGatherRays> directions;
  const double turn = std::numbers::pi * (3.0 - std::sqrt(5.0));
  for (int i = 0; i < kGatherRays; ++i) {
    const double squared = (i + 0.5) / kGatherRays;
    const double radius = std::sqrt(squared);
    directions[i] =
        Eigen::Vector3d(radius * std::cos(turn * i), radius * std::sin(turn * i), std::sqrt(1.0 - squared))
            .cast<float>();
  }
  return directions;
}

class Gatherer {
 public:
  Gatherer(const Scene& scene, RTCScene tracer, std::span<const float> reflectance,
           const std::vector<std::vector<Irradiance>>& direct)
      : scene_(scene), tracer_(tracer), reflectance_(reflectance), direct_(direct) {}

  /// Light of the first bounce, and as much more as the bounces after it would bring in surroundings as
  /// bright.
  Irradiance at(const Vector3f& p, const Vector3f& normal) const {
    const Eigen::Quaternionf turn = Eigen::Quaternionf::FromTwoVectors(Vector3f::UnitZ(), normal);
    Irradiance light{};
    float reflected = 0.0F;
    for (const Vector3f& direction : directions_) {
      addHit(p, turn * direction, light, reflected);
    }
    const float further = 1.0F / (1.0F - std::min(kMostReflected, reflected / kGatherRays));
    for (float& group : light) {
      group *= further / kGatherRays;
    }
    return light;
  }

 private:
  static constexpr float kMostReflected = 0.6F;

  void addHit(const Vector3f& p, const Vector3f& direction, Irradiance& light, float& reflected) const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRayHit ray{};
    ray.ray = makeRay(p, direction, std::numeric_limits<float>::infinity());
    ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(tracer_, &context, &ray);
    if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) {
      return;
    }
    const auto& triangle = scene_.surfaces[ray.hit.geomID].triangles[ray.hit.primID];
    const auto& corners = direct_[ray.hit.geomID];
    const std::array<float, 3> weights{1.0F - ray.hit.u - ray.hit.v, ray.hit.u, ray.hit.v};
    const float share = reflectance_[ray.hit.geomID];
    reflected += share;
    for (int i = 0; i < 3; ++i) {
      for (int group = 0; group < kLampGroups; ++group) {
        light[group] += share * weights[i] * corners[triangle[i]][group];
      }
    }
  }

  const Scene& scene_;
  const RTCScene tracer_;
  const std::span<const float> reflectance_;
  const std::vector<std::vector<Irradiance>>& direct_;
  const std::array<Vector3f, kGatherRays> directions_ = gatherDirections();
};

}  // namespace

std::vector<std::vector<Irradiance>> bakeLight(const Scene& scene, RTCScene tracer,
                                               std::span<const float> reflectance, WorkerPool& workers) {
  const std::size_t count = scene.surfaces.size();
  std::vector<std::vector<Vector3f>> points(count);
  std::vector<std::vector<Irradiance>> direct(count);
  workers.forEach(count, [&](std::size_t i) {
    points[i] = lightPoints(scene.surfaces[i]);
    for (std::size_t k = 0; k < points[i].size(); ++k) {
      direct[i].push_back(directLight(scene, tracer, points[i][k], scene.surfaces[i].vertices[k].normal));
    }
  });

  std::vector<std::vector<Irradiance>> light = direct;
  const Gatherer gatherer(scene, tracer, reflectance, direct);
  workers.forEach(count, [&](std::size_t i) {
    for (std::size_t k = 0; k < points[i].size(); ++k) {
      const Surface::Vertex& vertex = scene.surfaces[i].vertices[k];
      const Irradiance reflected = gatherer.at(points[i][k], vertex.normal);
      const Irradiance own = glow(scene, vertex);
      for (int group = 0; group < kLampGroups; ++group) {
        light[i][k][group] += reflected[group] + own[group];
      }
    }
  });
  return light;
}

}  // namespace rubble::arena_sim
