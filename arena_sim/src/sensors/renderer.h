#pragma once

#include <embree3/rtcore.h>

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "scene/scene.h"
#include "sensors/light_bake.h"
#include "sensors/ray_table.h"
#include "sensors/shutter.h"
#include "sensors/texture_set.h"
#include "sensors/worker_pool.h"

namespace rubble::arena_sim {

/// Linear light per pixel: blue, green, red, 0.
struct Radiance {
  Radiance(int width, int height);

  const Eigen::Array4f* row(int y) const { return &pixels[stride * y]; }
  Eigen::Array4f* row(int y) { return &pixels[stride * y]; }

  int width;
  int height;
  std::size_t stride;  // Rows and stride are padded as RayTable's.
  std::vector<Eigen::Array4f> pixels;
};

/// How bright the light is while a picture is taken.
struct LightLevels {
  std::array<Eigen::Array4f, kLampGroups> group;  // Blue, green, red, 0.
  float headlight = 0.0F;                         // At the camera: irradiance at 1 m.
};

/// Traces a picture's samples.
class Renderer {
 public:
  /// Keeps `textures` and `tracer`; `light` as bakeLight gave it.
  Renderer(const Scene& scene, RTCScene tracer, const std::vector<Texture>& textures,
           std::span<const std::vector<Irradiance>> light, const RayTable& rays, int samples);

  /// Every `noise` (of a frame) spreads the samples differently.
  void render(const Shutter& shutter, const LightLevels& levels, std::uint64_t noise, WorkerPool& workers,
              Radiance& radiance) const;

 private:
  struct Triangle {
    std::array<Eigen::Array4f, 3> corners;  // s, t, irradiance of both lamp groups
  };
  struct Look {
    const Texture::Level* levels;
    float last_level;
    float log2_pitch;
    std::uint32_t first_triangle;
  };
  struct Picture;
  struct Packet;

  void addSurface(const Surface& surface, const Texture& texture, const std::vector<Irradiance>& light);
  void renderTile(const Picture& picture, int x, int y) const;
  void renderBlock(const Picture& picture, int x, int y) const;
  void aim(const Picture& picture, int x, int y, int sample, Packet& packet) const;
  void trace(Packet& packet) const;
  void shade(const LightLevels& levels, const Packet& packet, std::span<Eigen::Array4f, 8> sums) const;

  RTCScene tracer_;
  const RayTable& rays_;
  const SamplePattern pattern_;
  std::vector<Look> looks_;
  std::vector<Triangle> triangles_;
};

}  // namespace rubble::arena_sim
