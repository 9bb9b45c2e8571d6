#include "sensors/renderer.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

namespace rubble::arena_sim {

namespace {

using Eigen::Array4f;
using Array8f = Eigen::Array<float, 8, 1>;
using Map8 = Eigen::Map<Array8f>;

constexpr int kTile = 16;  // pixels
constexpr int kLanes = 8;  // A packet: 4 x 2 pixels.
constexpr int kRows = 2;
constexpr int kColumns = RayTable::kGroup;
/// A texel is as large as 0.35 pixels: large enough that four samples neither miss texels nor make the
/// picture coarser than a lens does.
constexpr float kLog2Footprint = -1.5F;

Array4f load(const float* values) { return Eigen::Map<const Array4f>(values); }

Array4f between(const Array4f& from, const Array4f& to, const Array4f& share) {
  return from + share * (to - from);
}

/// To 0.09; linear between the powers of two.
float log2Of(float value) {
  constexpr float kMantissa = 0x1p-23F;
  constexpr float kBias = 127.0F;
  return static_cast<float>(std::bit_cast<std::int32_t>(value)) * kMantissa - kBias;
}

using Floats = float __attribute__((vector_size(16)));

struct TexelPair {
  Floats left;
  Floats right;
};

/// The reflectances of two texels side by side, in units of 1 / 255^2. Bytes are widened by interleaving them
/// with zeros: the compiler's own conversion goes byte by byte on plain x86-64.
TexelPair reflectancesOf(const std::uint32_t* texels) {
  using Bytes = std::uint8_t __attribute__((vector_size(16)));
  using Words = std::uint16_t __attribute__((vector_size(16)));
  using Ints = std::int32_t __attribute__((vector_size(16)));
  using Longs = std::uint64_t __attribute__((vector_size(16)));
  constexpr Bytes kNoByte{};
  constexpr Words kNoWord{};
  std::uint64_t both = 0;
  std::memcpy(&both, texels, sizeof(both));
  const Bytes widened = __builtin_shufflevector(std::bit_cast<Bytes>(Longs{both, 0}), kNoByte, 0, 16, 1, 17,
                                                2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23);
  const auto words = std::bit_cast<Words>(widened);
  const auto left = std::bit_cast<Ints>(__builtin_shufflevector(words, kNoWord, 0, 8, 1, 9, 2, 10, 3, 11));
  const auto right = std::bit_cast<Ints>(__builtin_shufflevector(words, kNoWord, 4, 12, 5, 13, 6, 14, 7, 15));
  const Floats a = __builtin_convertvector(left, Floats);
  const Floats b = __builtin_convertvector(right, Floats);
  return {a * a, b * b};
}

/// Between four texels, in units of 1 / 255^2.
Array4f fetch(const Texture::Level& level, float s, float t) {
  const float x = 0.5F + s * level.scale_x;
  const float y = 0.5F + t * level.scale_y;
  const auto column = static_cast<std::int32_t>(x);
  const auto row = static_cast<std::int32_t>(y);
  const std::uint32_t* texels = level.texels + static_cast<std::ptrdiff_t>(row) * level.stride + column;
  const float right = x - static_cast<float>(column);
  const float down = y - static_cast<float>(row);
  const TexelPair above = reflectancesOf(texels);
  const TexelPair below = reflectancesOf(texels + level.stride);
  const Floats left = above.left + down * (below.left - above.left);
  const Floats mean = left + right * (above.right + down * (below.right - above.right) - left);
  return Eigen::Map<const Array4f>(reinterpret_cast<const float*>(&mean));
}

}  // namespace

Radiance::Radiance(int width_in, int height_in)
    : width(width_in),
      height(height_in),
      stride(static_cast<std::size_t>((width_in + kColumns - 1) / kColumns * kColumns)),
      pixels(stride * static_cast<std::size_t>((height_in + 1) / kRows * kRows), Array4f::Zero()) {}

struct Renderer::Picture {
  const Shutter& shutter;
  const LightLevels& levels;
  /// Moves the sample pattern over the picture, by whole packets.
  int shift_x;
  int shift_y;
  Radiance& radiance;
};

struct Renderer::Packet {
  alignas(32) RTCRayHit8 rays;
  alignas(32) std::array<std::int32_t, kLanes> valid;
  Array8f log2_area;  // Solid angle of the sample.
  Array8f level;      // What is added to the mipmap level before rounding down.
  Array8f incidence;  // Cosine, filled in by trace().
};

Renderer::Renderer(const Scene& scene, RTCScene tracer, const std::vector<Texture>& textures,
                   std::span<const std::vector<Irradiance>> light, const RayTable& rays, int samples)
    : tracer_(tracer), rays_(rays), pattern_(samples) {
  for (std::size_t i = 0; i < scene.surfaces.size(); ++i) {
    addSurface(scene.surfaces[i], textures[i], light[i]);
  }
}

void Renderer::addSurface(const Surface& surface, const Texture& texture,
                          const std::vector<Irradiance>& light) {
  looks_.push_back({texture.levels().data(), static_cast<float>(texture.levels().size() - 1),
                    texture.log2Pitch(), static_cast<std::uint32_t>(triangles_.size())});
  constexpr float kWhite = 255.0F * 255.0F;
  for (const auto& triangle : surface.triangles) {
    Triangle& added = triangles_.emplace_back();
    for (int i = 0; i < 3; ++i) {
      const Eigen::Array2f place = surface.vertices[triangle[i]].uv.array() / surface.chart_size.array();
      const Irradiance& irradiance = light[triangle[i]];
      added.corners[i] = {std::clamp(place.x(), 0.0F, 1.0F), std::clamp(1.0F - place.y(), 0.0F, 1.0F),
                          irradiance[0] / kWhite, irradiance[1] / kWhite};
    }
  }
}

void Renderer::render(const Shutter& shutter, const LightLevels& levels, std::uint64_t noise,
                      WorkerPool& workers, Radiance& radiance) const {
  constexpr unsigned kPacketsX = SamplePattern::kSide / kColumns;
  constexpr unsigned kPacketsY = SamplePattern::kSide / kRows;
  const std::uint64_t hash = hashOf(noise);
  const Picture picture{shutter, levels, static_cast<int>(hash % kPacketsX) * kColumns,
                        static_cast<int>((hash >> 32U) % kPacketsY) * kRows, radiance};
  const int columns = (radiance.width + kTile - 1) / kTile;
  const int rows = (radiance.height + kTile - 1) / kTile;
  workers.forEach(static_cast<std::size_t>(rows), [&](std::size_t row) {
    for (int column = 0; column < columns; ++column) {
      renderTile(picture, column * kTile, static_cast<int>(row) * kTile);
    }
  });
}

void Renderer::renderTile(const Picture& picture, int x, int y) const {
  for (int row = y; row < std::min(y + kTile, picture.radiance.height); row += kRows) {
    for (int column = x; column < std::min(x + kTile, picture.radiance.width); column += kColumns) {
      renderBlock(picture, column, row);
    }
  }
}

void Renderer::renderBlock(const Picture& picture, int x, int y) const {
  std::array<Array4f, kLanes> sums;
  sums.fill(Array4f::Zero());
  Packet packet{};
  packet.valid.fill(-1);
  const auto samples = static_cast<int>(pattern_.tiles.size());
  for (int sample = 0; sample < samples; ++sample) {
    aim(picture, x, y, sample, packet);
    trace(packet);
    shade(picture.levels, packet, sums);
  }
  const float share = 1.0F / static_cast<float>(samples);
  for (int lane = 0; lane < kLanes; ++lane) {
    picture.radiance.row(y + lane / kColumns)[x + lane % kColumns] = share * sums[lane];
  }
}

void Renderer::aim(const Picture& picture, int x, int y, int sample, Packet& packet) const {
  const SamplePattern::Tile& tile = pattern_.tiles[sample];
  RTCRay8& rays = packet.rays.ray;
  for (int half = 0; half < kRows; ++half) {
    const int row = y + half;
    const int lane = half * kColumns;
    const std::size_t at =
        static_cast<std::size_t>((row + picture.shift_y) % SamplePattern::kSide) * SamplePattern::kSide +
        static_cast<std::size_t>((x + picture.shift_x) % SamplePattern::kSide);
    const Array4f right = load(&tile.x[at]);
    const Array4f down = load(&tile.y[at]);
    const std::size_t corner = rays_.stride * static_cast<std::size_t>(row) + static_cast<std::size_t>(x);
    const auto direction = [&](const std::vector<float>& table) -> Array4f {
      const float* above = &table[corner];
      const float* below = above + rays_.stride;
      return between(between(load(above), load(above + 1), right),
                     between(load(below), load(below + 1), right), down);
    };
    const Array4f dx = direction(rays_.x);
    const Array4f dy = direction(rays_.y);
    const Array4f dz = direction(rays_.z);

    const Shutter::Pose* poses = picture.shutter.row(row) + sample;
    const Array4f time = load(&tile.time[at]);
    const auto pose = [&](int i) -> Array4f { return poses[0][i] + time * (poses[1][i] - poses[0][i]); };
    Eigen::Map<Array4f>(rays.dir_x + lane) = pose(0) * dx + pose(1) * dy + pose(2) * dz;
    Eigen::Map<Array4f>(rays.org_x + lane) = pose(3);
    Eigen::Map<Array4f>(rays.dir_y + lane) = pose(4) * dx + pose(5) * dy + pose(6) * dz;
    Eigen::Map<Array4f>(rays.org_y + lane) = pose(7);
    Eigen::Map<Array4f>(rays.dir_z + lane) = pose(8) * dx + pose(9) * dy + pose(10) * dz;
    Eigen::Map<Array4f>(rays.org_z + lane) = pose(11);
    packet.log2_area.segment<kColumns>(lane) = load(&rays_.log2_area[corner]) + kLog2Footprint;
    packet.level.segment<kColumns>(lane) = load(&tile.level[at]);
  }
}

void Renderer::trace(Packet& packet) const {
  RTCRay8& rays = packet.rays.ray;
  RTCHit8& hits = packet.rays.hit;
  constexpr float kNearest = 1e-3F;
  std::fill_n(rays.tnear, kLanes, kNearest);
  std::fill_n(rays.tfar, kLanes, std::numeric_limits<float>::infinity());
  std::fill_n(rays.time, kLanes, 0.0F);
  std::fill_n(rays.mask, kLanes, 0xffffffffU);
  std::fill_n(rays.flags, kLanes, 0U);
  std::fill_n(hits.geomID, kLanes, RTC_INVALID_GEOMETRY_ID);
  std::fill_n(hits.instID[0], kLanes, RTC_INVALID_GEOMETRY_ID);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  rtcIntersect8(packet.valid.data(), tracer_, &context, &packet.rays);

  const Map8 nx(hits.Ng_x);
  const Map8 ny(hits.Ng_y);
  const Map8 nz(hits.Ng_z);
  const Array8f across = (nx * Map8(rays.dir_x) + ny * Map8(rays.dir_y) + nz * Map8(rays.dir_z)).abs();
  packet.incidence = across / (nx * nx + ny * ny + nz * nz).sqrt();
  // Half of log2 of the area that the sample sees.
  constexpr float kFlattest = 0.05F;
  const Array8f spread = Map8(rays.tfar) * Map8(rays.tfar) / packet.incidence.max(kFlattest);
  for (int lane = 0; lane < kLanes; ++lane) {
    packet.level[lane] += 0.5F * (log2Of(spread[lane]) + packet.log2_area[lane]);
  }
}

void Renderer::shade(const LightLevels& levels, const Packet& packet, std::span<Array4f, kLanes> sums) const {
  const RTCHit8& hits = packet.rays.hit;
  for (int lane = 0; lane < kLanes; ++lane) {
    if (hits.geomID[lane] == RTC_INVALID_GEOMETRY_ID) {
      continue;
    }
    const Look& look = looks_[hits.geomID[lane]];
    const Triangle& triangle = triangles_[look.first_triangle + hits.primID[lane]];
    const float u = hits.u[lane];
    const float v = hits.v[lane];
    const Array4f point =
        (1.0F - u - v) * triangle.corners[0] + u * triangle.corners[1] + v * triangle.corners[2];
    const float level = std::clamp(packet.level[lane] - look.log2_pitch, 0.0F, look.last_level);
    const Array4f reflectance = fetch(look.levels[static_cast<int>(level)], std::clamp(point[0], 0.0F, 1.0F),
                                      std::clamp(point[1], 0.0F, 1.0F));
    const float distance = packet.rays.ray.tfar[lane];
    constexpr float kWhite = 255.0F * 255.0F;
    constexpr float kLampSize = 0.1F;  // m; no singularity right before it.
    const float headlight =
        levels.headlight / kWhite * packet.incidence[lane] / (distance * distance + kLampSize * kLampSize);
    sums[lane] += reflectance * (point[2] * levels.group[0] + point[3] * levels.group[1] + headlight);
  }
}

}  // namespace rubble::arena_sim
