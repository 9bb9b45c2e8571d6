#include "world/site.h"

namespace rubble::arena_sim {

using Eigen::Vector2d;

void Site::addObstacle(const Polygon& outline) {
  for (std::size_t i = 0; i < outline.size(); ++i) {
    obstacles.push_back({outline[i], outline[(i + 1) % outline.size()]});
  }
}

Polygon rectangle(const common::Pose2& T_arena_rectangle, const Vector2d& size) {
  const Vector2d half = 0.5 * size;
  Polygon outline;
  for (const auto& [x, y] : {std::pair{-1.0, -1.0}, {1.0, -1.0}, {1.0, 1.0}, {-1.0, 1.0}}) {
    outline.emplace_back(T_arena_rectangle * Vector2d(x * half.x(), y * half.y()));
  }
  return outline;
}

Polygon thicken(const Segment& line, double thickness) {
  const Vector2d along = line.b - line.a;
  const Vector2d centre = 0.5 * (line.a + line.b);
  return rectangle({centre.x(), centre.y(), std::atan2(along.y(), along.x())}, {along.norm(), thickness});
}

Appearance boardLook(Random& random, double plain_share) {
  Appearance look;
  look.material = random.chance(plain_share)
                      ? Material::kPaint
                      : random.pick({Material::kOsb, Material::kOsb, Material::kPlywood, Material::kPlanks});
  look.seed = random.seed();
  return look;
}

void addLevelPrism(Scene& scene, const Polygon& outline, double bottom, double top, const Appearance& look,
                   bool drivable, float cell) {
  addPrism(scene.surfaces, outline, bottom, std::vector<double>(outline.size(), top), look, drivable, cell);
}

}  // namespace rubble::arena_sim
