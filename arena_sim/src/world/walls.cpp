#include "world/walls.h"

#include <algorithm>
#include <cmath>

namespace rubble::arena_sim {

namespace {

using Eigen::Vector2d;

constexpr double kPost = 0.07;
constexpr double kFrameShare = 0.3;

void addBoards(Site& site, const WallPiece& wall, Random& random) {
  const double length = (wall.line.b - wall.line.a).norm();
  const Vector2d along = (wall.line.b - wall.line.a) / length;
  double from = wall.outer ? -0.5 * wall.thickness : 0.0;
  const double end = wall.outer ? length - 0.5 * wall.thickness : length;
  while (from < end) {
    double to = from + random.uniform(1.2, 2.4);
    if (end - to < 0.4) {
      to = end;
    }
    const Segment line{wall.line.a + from * along, wall.line.a + to * along};
    addLevelPrism(site.scene, thicken(line, wall.thickness), 0.0, site.config.wall_height,
                  boardLook(random, site.config.plain_share));
    from = to;
  }
}

/// Posts at both jambs and a lintel over them, well above the robot.
void addFrame(Site& site, const Door& door, Random& random) {
  const double height = random.uniform(1.6, 1.9);
  const Appearance look{random.pick({Material::kPlanks, Material::kPaint, Material::kMetal}), random.seed(),
                        nullptr};
  const double yaw = std::atan2(door.along.y(), door.along.x());
  const double reach = 0.5 * door.width + 0.5 * kPost;
  for (const double side : {-1.0, 1.0}) {
    const Vector2d p = door.centre + side * reach * door.along;
    const Polygon post = rectangle({p.x(), p.y(), yaw}, {kPost, kPost});
    addLevelPrism(site.scene, post, 0.0, height, look);
    site.addObstacle(post);
  }
  common::Pose3 T = common::pose3FromPose2({door.centre.x(), door.centre.y(), yaw}, height + 0.5 * kPost);
  addBox(site.scene.surfaces, T, {2.0 * reach + kPost, kPost, kPost}, look, false);
}

void addPatches(Site& site, const Polygon& polygon, Random& random) {
  constexpr double kLargest = 9.0;  // m^2
  const bool along_x = spanOf(polygon, Vector2d::UnitX()) > spanOf(polygon, Vector2d::UnitY());
  if (areaOf(polygon) > kLargest || (areaOf(polygon) > 0.4 * kLargest && random.chance(0.5))) {
    const Vector2d axis = along_x ? Vector2d::UnitX() : Vector2d::UnitY();
    Vector2d centre = Vector2d::Zero();
    for (const Vector2d& p : polygon) {
      centre += p / static_cast<double>(polygon.size());
    }
    const double tilt = random.chance(0.2) ? random.uniform(-0.2, 0.2) : 0.0;
    const double angle = std::atan2(axis.x(), -axis.y()) + tilt;
    const auto parts = cut(polygon, centre + random.uniform(-0.15, 0.15) * spanOf(polygon, axis) * axis,
                           {std::cos(angle), std::sin(angle)});
    if (parts) {
      addPatches(site, parts->left, random);
      addPatches(site, parts->right, random);
      return;
    }
  }
  Material material = random.pick({Material::kConcrete, Material::kPlywood, Material::kCarpet});
  if (site.config.floor == "concrete") {
    material = Material::kConcrete;
  } else if (site.config.floor == "plywood") {
    material = Material::kPlywood;
  } else if (site.config.floor == "carpet") {
    material = Material::kCarpet;
  }
  std::vector<Eigen::Vector3d> corners;
  for (const Vector2d& p : polygon) {
    corners.emplace_back(p.x(), p.y(), 0.0);
  }
  site.scene.surfaces.push_back(makePolygon(corners, {material, random.seed(), nullptr}));
  site.scene.surfaces.back().drivable = true;
}

}  // namespace

void buildWalls(Site& site, Random& random) {
  for (const WallPiece& wall : site.plan.walls) {
    addBoards(site, wall, random);
    site.addObstacle(thicken(wall.line, wall.thickness));
  }
  for (const Door& door : site.plan.doors) {
    if (random.chance(kFrameShare)) {
      addFrame(site, door, random);
    }
  }
}

void buildFloor(Site& site, Random& random) {
  const auto [w, d] = std::pair{site.plan.size.x(), site.plan.size.y()};
  addPatches(site, {{0.0, 0.0}, {w, 0.0}, {w, d}, {0.0, d}}, random);
}

}  // namespace rubble::arena_sim
