#include "scene/wood_grain.h"

#include <algorithm>
#include <cmath>

#include "scene/canvas.h"

namespace rubble::arena_sim {

namespace {

constexpr int kPerRing = 16;
constexpr int kRings = 256;
constexpr std::size_t kProfile = std::size_t{kPerRing} * kRings;

/// Early wood darkens slowly into late wood, then starts anew; no two rings alike.
std::vector<float> ringProfile(std::uint64_t seed) {
  Dice dice(seed, 3);
  std::vector<float> profile;
  while (profile.size() < kProfile) {
    const int width = kPerRing / 2 + dice.below(kPerRing);
    const float depth = dice.uniform(0.3F, 1.6F);
    for (int i = 0; i < width; ++i) {
      const float t = static_cast<float>(i) / static_cast<float>(width);
      profile.push_back(depth * (0.45F - 1.6F * t * t * t * (t < 0.9F ? 1.0F : 5.0F * (1.0F - t) + 0.5F)));
    }
  }
  profile.resize(kProfile);
  return profile;
}

}  // namespace

WoodGrain::WoodGrain(std::uint64_t seed, float pixel, const Shape& shape)
    : shape_(shape),
      pixel_(pixel),
      waves_(derivedSeed(seed, 1), pixel, shape.wave_length, 0.14F, 4, 0.4F),
      fibres_(derivedSeed(seed, 2), pixel, 0.5F, 0.02F, 4, 0.85F),
      profile_(ringProfile(seed)) {}

void WoodGrain::startRow(int y, std::size_t columns) {
  wave_row_.assign(columns, 0.0F);
  fibre_row_.assign(columns, 0.0F);
  knot_row_.assign(columns, 0.0F);
  waves_.addRow(y, shape_.waviness, wave_row_);
  fibres_.addRow(y, shape_.fibre_contrast, fibre_row_);
}

void WoodGrain::bendAround(const Knot& knot, float v, std::size_t begin, std::size_t end) {
  const float reach_u = 9.0F * knot.radius;
  const float reach_v = 3.5F * knot.radius;
  const float dv = (v - knot.place.y) / reach_v;
  if (std::abs(dv) >= 1.0F) {
    return;
  }
  const float bend = 2.2F * knot.radius / shape_.ring;
  const auto first = static_cast<long>((knot.place.x - reach_u) / pixel_);
  const auto last = static_cast<long>((knot.place.x + reach_u) / pixel_) + 1;
  for (auto x = std::max(first, static_cast<long>(begin)); x < std::min(last, static_cast<long>(end)); ++x) {
    const float du = (static_cast<float>(x) * pixel_ - knot.place.x) / reach_u;
    const float rest = std::max(0.0F, 1.0F - du * du - dv * dv);
    wave_row_[static_cast<std::size_t>(x)] +=
        bend * rest * rest * (knot.place.y < v ? 1.0F : -1.0F) * std::min(1.0F, 3.0F * std::abs(dv));
    const float du_heart = (static_cast<float>(x) * pixel_ - knot.place.x) / (1.3F * knot.radius);
    const float dv_heart = (v - knot.place.y) / knot.radius;
    const float r = std::sqrt(du_heart * du_heart + dv_heart * dv_heart);
    if (r < 1.5F) {
      const float rim = std::max(0.0F, 1.0F - std::abs(r - 1.0F) * 4.0F);
      const float heart = std::clamp((1.1F - r) * 5.0F, 0.0F, 1.0F);
      knot_row_[static_cast<std::size_t>(x)] -= 30.0F * rim + heart * (38.0F + 9.0F * std::sin(14.0F * r));
    }
  }
}

void WoodGrain::piece(std::size_t begin, std::size_t end, float v, float offset, std::span<const Knot> knots,
                      std::span<float> tones) {
  for (const Knot& knot : knots) {
    bendAround(knot, v, begin, end);
  }
  const float base = (v / shape_.ring + offset) + static_cast<float>(kRings) * 8.0F;
  for (std::size_t x = begin; x < end; ++x) {
    const float place = (base + wave_row_[x]) * static_cast<float>(kPerRing);
    const auto i = static_cast<unsigned>(place);
    const float share = place - static_cast<float>(i);
    const float a = profile_[i % kProfile];
    const float b = profile_[(i + 1) % kProfile];
    tones[x] += shape_.ring_contrast * (a + share * (b - a)) + fibre_row_[x] + knot_row_[x];
  }
}

}  // namespace rubble::arena_sim
