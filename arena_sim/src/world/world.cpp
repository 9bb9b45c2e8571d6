#include "world/world.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "common/error.h"
#include "world/furniture.h"
#include "world/hall.h"
#include "world/ramp_field.h"
#include "world/signs_placement.h"
#include "world/site.h"
#include "world/victims.h"
#include "world/walls.h"

namespace rubble::arena_sim {

namespace {

using Eigen::Vector2d;

// Purposes of random numbers: one can change without the others.
enum Stream : std::uint32_t { kPlan, kWalls, kStart, kRamps, kFurniture, kVictims, kSigns, kHall };

double distanceToWalls(const Site& site, const Vector2d& p) {
  double nearest = std::numeric_limits<double>::max();
  for (const Segment& s : site.obstacles) {
    nearest = std::min(nearest, distanceTo(s, p));
  }
  return nearest;
}

void addExtraWalls(Site& site) {
  for (const ExtraWall& wall : site.config.walls) {
    const Segment line{{wall.from[0], wall.from[1]}, {wall.to[0], wall.to[1]}};
    constexpr double kShortest = 0.1;
    for (const Vector2d& p : {line.a, line.b}) {
      if (p.minCoeff() < 0.0 || p.x() > site.plan.size.x() || p.y() > site.plan.size.y()) {
        throw common::Error(
            fmt::format("arena_sim.world.walls: [{}, {}] is outside of the arena of {:.2f} x {:.2f} m", p.x(),
                        p.y(), site.plan.size.x(), site.plan.size.y()));
      }
    }
    if ((line.b - line.a).norm() < kShortest) {
      throw common::Error(fmt::format("arena_sim.world.walls: the wall from [{}, {}] is shorter than {} m",
                                      line.a.x(), line.a.y(), kShortest));
    }
    site.plan.walls.push_back({line, 0.03, false});
  }
}

void checkStart(const Site& site) {
  const Vector2d p = site.start.translation();
  if (!roomAt(site.plan, p)) {
    throw common::Error(
        fmt::format("arena_sim.world.start: [{}, {}] is in no room; the arena is {:.2f} x {:.2f} m, its "
                    "corner is at [0, 0]",
                    p.x(), p.y(), site.plan.size.x(), site.plan.size.y()));
  }
  const double distance = distanceToWalls(site, p);
  if (distance < kStartClearance) {
    throw common::Error(fmt::format(
        "arena_sim.world.start: [{}, {}] is {:.2f} m from a wall; the robot needs {} m, move it or say "
        "arena_sim.world.start_by_seed: true",
        p.x(), p.y(), distance, kStartClearance));
  }
}

/// A pose with free ground ahead, where the robot can begin to drive without a turn.
common::Pose2 drawStart(const Site& site, Random& random) {
  constexpr int kAttempts = 4000;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    const common::Pose2 pose{random.uniform(0.0, site.plan.size.x()), random.uniform(0.0, site.plan.size.y()),
                             0.5 * std::numbers::pi * random.integer(0, 3) + random.uniform(-0.15, 0.15)};
    const auto room = roomAt(site.plan, pose.translation());
    if (!room || room == site.plan.approach) {
      continue;
    }
    bool clear = true;
    for (double ahead = 0.0; ahead < 1.6; ahead += 0.2) {
      clear = clear && distanceToWalls(site, pose * Vector2d(ahead, 0.0)) > kStartClearance + 0.05;
    }
    if (clear) {
      return pose;
    }
  }
  throw common::Error(
      "the arena has no free place for the robot to start; enlarge arena_sim.world.width and "
      "arena_sim.world.depth or give "
      "arena_sim.world.start");
}

World inFrameOfStart(Site site) {
  const common::Pose2 T_world_arena = site.start.inverse();
  const common::Pose3 T = common::pose3FromPose2(T_world_arena);
  const auto move = [&](auto& points) {
    for (Vector2d& p : points) {
      p = T_world_arena * p;
    }
  };
  const auto moveSegment = [&](Segment& s) { s = {T_world_arena * s.a, T_world_arena * s.b}; };

  World world;
  world.start_room = *roomAt(site.plan, site.start.translation());
  world.rooms = std::move(site.plan.rooms);
  world.ramp_fields = std::move(site.ramp_fields);
  world.objects = std::move(site.objects);
  world.obstacles = std::move(site.obstacles);
  world.scene = std::move(site.scene);
  if (site.plan.crossing) {
    world.crossing = describeCrossing(*site.plan.crossing);
    for (auto* points :
         {&world.crossing->way, &world.crossing->block, &world.crossing->ramp, &world.crossing->stairs}) {
      move(*points);
    }
    moveSegment(world.crossing->front);
    std::for_each(world.crossing->walls.begin(), world.crossing->walls.end(), moveSegment);
  }
  std::for_each(world.rooms.begin(), world.rooms.end(), move);
  std::for_each(world.ramp_fields.begin(), world.ramp_fields.end(), move);
  std::for_each(world.obstacles.begin(), world.obstacles.end(), moveSegment);
  for (WorldObject& object : world.objects) {
    object.T_world_object = T * object.T_world_object;
  }
  for (Surface& surface : world.scene.surfaces) {
    for (Surface::Vertex& vertex : surface.vertices) {
      vertex.p_world = (T * vertex.p_world.cast<double>()).cast<float>();
      vertex.normal = (T.linear() * vertex.normal.cast<double>()).cast<float>();
    }
  }
  const bool quarter_turned = std::abs(std::sin(T_world_arena.yaw)) > std::sqrt(0.5);
  for (Lamp& lamp : world.scene.lamps) {
    lamp.p_world = T * lamp.p_world;
    if (quarter_turned) {
      std::swap(lamp.half_size.x(), lamp.half_size.y());
    }
  }
  return world;
}

}  // namespace

void visit(common::ConfigSection& section, ExtraWall& wall) {
  section.numbers("from", wall.from, "m", 0.0, 60.0, "one end, in the frame of the arena");
  section.numbers("to", wall.to, "m", 0.0, 60.0, "the other end");
}

void visit(common::ConfigSection& section, WorldConfig& config) {
  section.number("width", config.width, "m", 2.5, 20.0, "of the arena along x, its corner is the origin");
  section.number("depth", config.depth, "m", 2.5, 16.0, "of the arena along y");
  section.number("size_variation", config.size_variation, "", 0.0, 0.3,
                 "share by which the seed changes width and depth");
  section.number("wall_height", config.wall_height, "m", 0.6, 2.5, "of the boards");
  section.number("plain_share", config.plain_share, "", 0.0, 1.0, "of boards that are painted plain");
  section.choice("floor", config.floor, {"mixed", "concrete", "plywood", "carpet"}, "what the ground is of");
  section.flag("crossing", config.crossing, "a steep ramp, a high platform and stairs down from it");
  section.numbers("ramp_angle", config.ramp_angle, "degrees", 15.0, 60.0,
                  "flattest and steepest of the crossing");
  section.numbers("platform_height", config.platform_height, "m", 0.5, 2.0,
                  "lowest and highest of the crossing");
  section.flag("ramp_fields", config.ramp_fields, "rooms with low pitch and roll ramps");
  section.integer("victims", config.victims, "", 0, 20, "dolls");
  section.integer("hazard_labels", config.hazard_labels, "", 0, 40, "on walls and in boxes");
  section.integer("qr_codes", config.qr_codes, "", 0, 40, "on walls");
  section.integer("april_tags", config.april_tags, "", 0, 40, "on walls");
  section.flag("start_by_seed", config.start_by_seed, "the robot starts where the seed says, not at `start`");
  section.numbers("start", config.start, "m, m, rad", -60.0, 60.0, "x, y, yaw in the frame of the arena");
  section.sections("walls", config.walls, "more walls");
}

World makeWorld(const WorldConfig& config, std::uint64_t seed) {
  const auto stream = [&](Stream purpose) { return Random(randomStream(seed, 100 + purpose)); };
  Random plan = stream(kPlan);
  Random walls = stream(kWalls);
  Random start = stream(kStart);
  Random ramps = stream(kRamps);
  Random furniture = stream(kFurniture);
  Random victims = stream(kVictims);
  Random signs = stream(kSigns);
  Random hall = stream(kHall);

  Site site;
  site.config = config;
  site.plan = drawFloorPlan(config, plan);
  addExtraWalls(site);
  buildFloor(site, walls);
  buildWalls(site, walls);
  if (config.crossing) {
    buildCrossing(site, walls);
  }
  site.start = config.start_by_seed ? drawStart(site, start)
                                    : common::Pose2{config.start[0], config.start[1], config.start[2]};
  checkStart(site);
  if (config.ramp_fields) {
    buildRampFields(site, ramps);
  }
  const std::vector<OpenBox> boxes = buildVictims(site, victims);
  buildFurniture(site, furniture);
  placeSigns(site, boxes, signs);
  buildHall(site, hall);
  return inFrameOfStart(std::move(site));
}

std::mt19937_64 randomStream(std::uint64_t seed, std::uint32_t stream) {
  std::seed_seq mixed{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32), stream};
  return std::mt19937_64(mixed);
}

}  // namespace rubble::arena_sim
