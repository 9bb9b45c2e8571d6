#include "world/furniture.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace rubble::arena_sim {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kPassage = 0.85;  // Wide enough for the robot.
constexpr double kTouching = 0.12;
constexpr double kLowest = 0.47;  // Of an obstacle: the LiDAR sees its sides.
constexpr double kAreaPerPiece = 4.0;

Polygon circle(const Vector2d& p, double radius, int corners, double turn, double jitter, Random& random) {
  Polygon outline;
  for (int i = 0; i < corners; ++i) {
    const double angle = turn + 2.0 * std::numbers::pi * i / corners;
    const double r = radius * (1.0 - random.uniform(0.0, jitter));
    outline.emplace_back(p + r * Vector2d(std::cos(angle), std::sin(angle)));
  }
  return outline;
}

common::Pose3 tilted(const Vector2d& p, double z, Random& random, double tilt) {
  common::Pose3 T = common::Pose3::Identity();
  T.linear() = common::rotationFromRpy({random.uniform(-tilt, tilt), random.uniform(-tilt, tilt),
                                        random.uniform(-std::numbers::pi, std::numbers::pi)});
  T.translation() = Vector3d(p.x(), p.y(), z);
  return T;
}

void addCrates(Site& site, const Footprint& place, Random& random) {
  const double yaw = random.uniform(-std::numbers::pi, std::numbers::pi);
  const double side = place.radius * std::numbers::sqrt2;
  const Vector3d size(side * random.uniform(0.8, 1.0), side * random.uniform(0.7, 1.0),
                      random.uniform(kLowest, 0.75));
  addCrate(site, {place.p.x(), place.p.y(), yaw}, size, 0.0, random);
  if (random.chance(0.5)) {
    const Vector3d upper = size.cwiseProduct(
        Vector3d(random.uniform(0.6, 0.8), random.uniform(0.6, 0.8), random.uniform(0.5, 0.9)));
    addCrate(site, {place.p.x(), place.p.y(), yaw + random.uniform(-0.5, 0.5)}, upper, size.z(), random);
  }
}

void addBarrel(Site& site, const Footprint& place, Random& random) {
  const Polygon outline = circle(place.p, std::min(place.radius, 0.3), 24, 0.0, 0.0, random);
  const Appearance look{random.pick({Material::kMetal, Material::kMetal, Material::kPaint}), random.seed(),
                        nullptr};
  addLevelPrism(site.scene, outline, 0.0, random.uniform(0.75, 0.95), look);
  site.addObstacle(outline);
}

/// A jagged core with bricks on and around it.
void addRubble(Site& site, const Footprint& place, Random& random) {
  const double core = 0.72 * place.radius;
  const double height = random.uniform(kLowest, 0.6);
  addLevelPrism(site.scene, circle(place.p, core, 7, random.uniform(0.0, 1.0), 0.3, random), 0.0, height,
                {Material::kConcrete, random.seed(), nullptr});
  const int bricks = random.integer(6, 10);
  for (int i = 0; i < bricks; ++i) {
    const double angle = 2.0 * std::numbers::pi * (i + random.uniform(-0.3, 0.3)) / bricks;
    const Vector2d out(std::cos(angle), std::sin(angle));
    const bool on_top = random.chance(0.55);
    const Vector3d size =
        random.chance(0.7) ? Vector3d(0.24, 0.115, 0.07) : Vector3d(random.uniform(0.15, 0.3), 0.15, 0.09);
    const Vector2d p = place.p + (on_top ? random.uniform(0.0, 0.5) * core : 0.85 * place.radius) * out;
    addBox(site.scene.surfaces, tilted(p, on_top ? height + 0.04 : 0.05, random, on_top ? 0.35 : 0.2), size,
           {random.pick({Material::kBricks, Material::kConcrete}), random.seed(), nullptr}, false);
  }
  site.addObstacle(circle(place.p, place.radius, 10, 0.0, 0.0, random));
}

void addPost(Site& site, const Footprint& place, Random& random) {
  const double side = random.uniform(0.07, 0.11);
  const Polygon outline = rectangle({place.p.x(), place.p.y(), random.uniform(0.0, 1.5)}, {side, side});
  addLevelPrism(site.scene, outline, 0.0, random.uniform(1.2, 1.8), boardLook(random, 0.1));
  site.addObstacle(outline);
}

/// Flat boards to drive over.
void addBoardsOnFloor(Site& site, Random& random) {
  const int boards = random.integer(3, 6);
  std::vector<Footprint> laid;
  for (int i = 0, attempt = 0; i < boards && attempt < 200; ++attempt) {
    const Vector2d p(random.uniform(0.0, site.plan.size.x()), random.uniform(0.0, site.plan.size.y()));
    const Vector2d size(random.uniform(0.6, 1.0), random.uniform(0.1, 0.2));
    const double radius = 0.5 * size.norm();
    const auto room = roomAt(site.plan, p);
    const auto apart = [&](const Footprint& other) { return (other.p - p).norm() > other.radius + radius; };
    const bool on_field = std::any_of(site.ramp_fields.begin(), site.ramp_fields.end(),
                                      [&](const Polygon& cell) { return depthInside(cell, p) > -radius; });
    if (!room || depthInside(site.plan.rooms[*room], p) < radius + 0.05 || on_field ||
        (p - site.start.translation()).norm() < radius + 0.6 ||
        !std::all_of(site.footprints.begin(), site.footprints.end(), apart) ||
        !std::all_of(laid.begin(), laid.end(), apart)) {
      continue;
    }
    laid.push_back({p, radius});
    ++i;
    const Polygon outline = rectangle({p.x(), p.y(), random.uniform(-3.0, 3.0)}, size);
    addLevelPrism(site.scene, outline, 0.0, random.uniform(0.015, 0.03),
                  {random.pick({Material::kPlanks, Material::kPlywood}), random.seed(), nullptr}, true);
  }
}

/// Usually against a wall, sometimes in the middle of a room.
Footprint samplePlace(const Site& site, const Polygon& room, Random& random) {
  const double radius = random.uniform(0.22, 0.45);
  if (random.chance(0.3)) {
    return {{random.uniform(0.0, site.plan.size.x()), random.uniform(0.0, site.plan.size.y())}, radius};
  }
  const auto edge = static_cast<std::size_t>(random.integer(0, static_cast<int>(room.size()) - 1));
  const Vector2d& a = room[edge];
  const Vector2d along = room[(edge + 1) % room.size()] - a;
  const Vector2d inwards = Vector2d(-along.y(), along.x()).normalized();
  return {a + random.uniform(0.0, 1.0) * along + (radius + 0.04) * inwards, radius};
}

}  // namespace

std::optional<std::size_t> roomAt(const FloorPlan& plan, const Vector2d& p) {
  for (std::size_t i = 0; i < plan.rooms.size(); ++i) {
    if (depthInside(plan.rooms[i], p) > 0.0) {
      return i;
    }
  }
  return std::nullopt;
}

bool isFree(const Site& site, const Footprint& footprint) {
  const Vector2d& p = footprint.p;
  const double radius = footprint.radius;
  const auto room = roomAt(site.plan, p);
  if (!room || room == site.plan.approach ||
      (p - site.start.translation()).norm() < radius + kStartClearance + 0.1) {
    return false;
  }
  const Vector2d ahead = site.start * Vector2d(1.7, 0.0);
  if (distanceTo({site.start.translation(), ahead}, p) < radius + 0.45) {
    return false;
  }
  const Polygon& outline = site.plan.rooms[*room];
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Vector2d edge = outline[(i + 1) % outline.size()] - outline[i];
    const Vector2d inwards = Vector2d(-edge.y(), edge.x()).normalized();
    const double gap = (p - outline[i]).dot(inwards) - radius;
    if (gap < 0.03 || (gap > kTouching && gap < kPassage)) {
      return false;
    }
  }
  const auto passable = [&](double gap) { return gap > kPassage; };
  return std::all_of(site.plan.doors.begin(), site.plan.doors.end(),
                     [&](const Door& door) { return passable((door.centre - p).norm() - radius); }) &&
         std::all_of(site.footprints.begin(), site.footprints.end(),
                     [&](const Footprint& f) { return passable((f.p - p).norm() - radius - f.radius); }) &&
         std::none_of(site.ramp_fields.begin(), site.ramp_fields.end(),
                      [&](const Polygon& cell) { return depthInside(cell, p) > -radius; }) &&
         std::all_of(site.config.walls.begin(), site.config.walls.end(), [&](const ExtraWall& wall) {
           const Segment line{{wall.from[0], wall.from[1]}, {wall.to[0], wall.to[1]}};
           return passable(distanceTo(line, p) - radius);
         });
}

void addCrate(Site& site, const common::Pose2& T_arena_crate, const Vector3d& size, double bottom,
              Random& random) {
  const Polygon outline = rectangle(T_arena_crate, size.head<2>());
  addLevelPrism(site.scene, outline, bottom, bottom + size.z(),
                {random.pick({Material::kCardboard, Material::kOsb, Material::kPlanks, Material::kPlywood}),
                 random.seed(), nullptr});
  if (bottom == 0.0) {
    site.addObstacle(outline);
  }
}

void buildFurniture(Site& site, Random& random) {
  constexpr int kAttempts = 200;
  const std::vector<Polygon>& rooms = site.plan.rooms;
  for (const Polygon& room : rooms) {
    const int wanted = std::max(1, static_cast<int>(areaOf(room) / kAreaPerPiece + random.uniform(0.0, 1.0)));
    for (int attempt = 0, placed = 0; attempt < kAttempts && placed < wanted; ++attempt) {
      Footprint place = samplePlace(site, room, random);
      const int kind = random.integer(0, 7);
      if (kind == 7) {
        place.radius = 0.08;
      }
      if (!isFree(site, place)) {
        continue;
      }
      ++placed;
      site.footprints.push_back(place);
      if (kind < 3) {
        addCrates(site, place, random);
      } else if (kind < 5) {
        addBarrel(site, place, random);
      } else if (kind < 7) {
        addRubble(site, place, random);
      } else {
        addPost(site, place, random);
      }
    }
  }
  addBoardsOnFloor(site, random);
}

}  // namespace rubble::arena_sim
