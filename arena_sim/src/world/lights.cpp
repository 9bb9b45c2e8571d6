#include "world/lights.h"

#include <algorithm>
#include <cmath>

namespace rubble::arena_sim {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kHallShare = 0.8;
constexpr double kWorkShare = 0.2;
constexpr double kHousing = 0.06;
constexpr double kPost = 0.05;

void addLamp(Site& site, const Vector3d& p, const Vector2d& half_size, int group, Random& random) {
  site.scene.lamps.push_back({p, half_size, 1.0, group});
  common::Pose3 T = common::Pose3::Identity();
  T.translation() = p + Vector3d(0.0, 0.0, 0.5 * kHousing + 0.01);
  addBox(site.scene.surfaces, T, {2.0 * half_size.x(), 2.0 * half_size.y(), kHousing},
         {Material::kMetal, random.seed(), nullptr}, false, 1.0F);
}

void addHallLamps(Site& site, const HallSize& hall, Random& random) {
  const int rows = random.integer(2, 3);
  const int columns = rows == 2 ? random.integer(4, 6) : random.integer(3, 4);
  const double z = hall.size.z() - random.uniform(1.15, 1.4);
  const Vector2d half_size = random.chance(0.5) ? Vector2d(0.7, 0.25) : Vector2d(0.4, 0.4);
  for (int i = 0; i < columns; ++i) {
    for (int j = 0; j < rows; ++j) {
      const Vector2d share((i + 0.5) / columns - 0.5, (j + 0.5) / rows - 0.5);
      const Vector2d jitter(random.uniform(-0.4, 0.4), random.uniform(-0.4, 0.4));
      const Vector2d p = hall.centre + 0.85 * share.cwiseProduct(hall.size.head<2>()) + jitter;
      addLamp(site, {p.x(), p.y(), z}, half_size, 0, random);
    }
  }
}

/// Beside the middle of outer walls, just outside, so that no way is narrower for them.
void addWorkLights(Site& site, Random& random) {
  std::vector<WallPiece> outer;
  std::copy_if(site.plan.walls.begin(), site.plan.walls.end(), std::back_inserter(outer),
               [](const WallPiece& wall) { return wall.outer; });
  std::shuffle(outer.begin(), outer.end(), random.engine());
  const int lights = random.integer(2, static_cast<int>(outer.size()));
  for (int i = 0; i < lights; ++i) {
    const Segment& line = outer[static_cast<std::size_t>(i)].line;
    const Vector2d along = (line.b - line.a).normalized();
    const Vector2d inwards(-along.y(), along.x());
    const Vector2d foot = line.a + random.uniform(0.2, 0.8) * (line.b - line.a) - 0.06 * inwards;
    const double height = random.uniform(2.3, 2.8);
    const Appearance steel{Material::kMetal, random.seed(), nullptr};
    addLevelPrism(site.scene, rectangle({foot.x(), foot.y(), 0.0}, {kPost, kPost}), 0.0, height, steel);
    const Vector2d p = foot + 0.35 * inwards;
    addLamp(site, {p.x(), p.y(), height}, {0.14, 0.14}, 1, random);
  }
}

double lightAt(const Lamp& lamp, const Vector2d& p) {
  const Vector3d d = lamp.p_world - Vector3d(p.x(), p.y(), 0.0);
  const double area = 4.0 * lamp.half_size.x() * lamp.half_size.y();
  return lamp.power * area * d.z() * d.z() / std::pow(d.squaredNorm(), 2);
}

/// Scales a group so that it sends `wanted` to the arena's floor on average.
void balance(Site& site, int group, double wanted) {
  constexpr int kPoints = 12;
  double sum = 0.0;
  for (int i = 0; i < kPoints; ++i) {
    for (int j = 0; j < kPoints; ++j) {
      const Vector2d p = site.plan.size.cwiseProduct(Vector2d((i + 0.5) / kPoints, (j + 0.5) / kPoints));
      for (const Lamp& lamp : site.scene.lamps) {
        sum += lamp.group == group ? lightAt(lamp, p) : 0.0;
      }
    }
  }
  for (Lamp& lamp : site.scene.lamps) {
    lamp.power *= lamp.group == group ? wanted * kPoints * kPoints / sum : 1.0;
  }
}

}  // namespace

void addLights(Site& site, const HallSize& hall, Random& random) {
  addHallLamps(site, hall, random);
  addWorkLights(site, random);
  balance(site, 0, kHallShare);
  balance(site, 1, kWorkShare);
}

}  // namespace rubble::arena_sim
