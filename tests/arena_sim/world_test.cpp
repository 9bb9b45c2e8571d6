#include "world/world.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "scene/ray_tracer.h"
#include "support/error_text.h"

namespace rubble::arena_sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

WorldConfig flat() {
  WorldConfig config;
  config.crossing = false;
  config.ramp_fields = false;
  return config;
}

double distanceToObstacles(const World& world, const Vector2d& p) {
  double nearest = 1e9;
  for (const Segment& s : world.obstacles) {
    nearest = std::min(nearest, distanceTo(s, p));
  }
  return nearest;
}

void expectObjects(const World& world, const WorldConfig& config) {
  std::map<std::string, int> counts;
  std::set<std::string> ids;
  for (const WorldObject& object : world.objects) {
    ++counts[object.kind];
    ids.insert(object.id);
  }
  EXPECT_EQ(ids.size(), world.objects.size());
  EXPECT_EQ(counts["victim"], config.victims);
  EXPECT_EQ(counts["hazard"], config.hazard_labels);
  EXPECT_EQ(counts["qr"], config.qr_codes);
  EXPECT_EQ(counts["apriltag"], config.april_tags);
}

/// Every picture is the first thing that a ray from in front of it meets, and something solid is behind it.
void expectPicturesInSight(const World& world) {
  const RayTracer tracer(world.scene);
  for (const WorldObject& object : world.objects) {
    if (object.kind == "victim") {
      continue;
    }
    SCOPED_TRACE(object.id);
    const common::Pose3& T = object.T_world_object;
    EXPECT_GT(T.translation().z(), 0.1);
    EXPECT_NEAR(T.linear()(2, 1), 1.0, 1e-9);  // Upright.
    for (const double u : {-0.45, 0.0, 0.45}) {
      for (const double v : {-0.45, 0.0, 0.45}) {
        const Vector3d p(u * object.size.x(), v * object.size.y(), 0.0);
        constexpr double kFrom = 0.35;
        const auto hit = tracer.cast(T * (p + kFrom * Vector3d::UnitZ()), -T.linear().col(2));
        ASSERT_TRUE(hit);
        EXPECT_NEAR(hit->distance, kFrom, 1e-4);
        EXPECT_TRUE(world.scene.surfaces[hit->surface].appearance.picture);
        const auto wall = tracer.cast(T * (p - 1e-3 * Vector3d::UnitZ()), -T.linear().col(2));
        ASSERT_TRUE(wall);
        EXPECT_LT(wall->distance, 0.01);
      }
    }
  }
}

void expectPassable(const Crossing& crossing) {
  for (std::size_t i = 1; i < crossing.way.size(); ++i) {
    for (double share = 0.0; share <= 1.0; share += 0.1) {
      const Vector2d p = crossing.way[i - 1] + share * (crossing.way[i] - crossing.way[i - 1]);
      for (const Segment& wall : crossing.walls) {
        ASSERT_GT(distanceTo(wall, p), 0.42);
      }
    }
  }
}

TEST(World, IsValidForManySeeds) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    WorldConfig config;
    if (seed > 6) {  // Signs take time to draw.
      config.hazard_labels = config.qr_codes = config.april_tags = 1;
    }
    const World world = makeWorld(config, seed);
    EXPECT_GE(world.rooms.size(), 6U);
    EXPECT_GE(distanceToObstacles(world, Vector2d::Zero()), kStartClearance);
    EXPECT_GT(depthInside(world.rooms[world.start_room], Vector2d::Zero()), 0.0);
    expectObjects(world, config);
    EXPECT_FALSE(world.ramp_fields.empty());
    ASSERT_TRUE(world.crossing);
    expectPassable(*world.crossing);
    EXPECT_GE(distanceToObstacles(world, world.crossing->way.front()), 0.6);
    EXPECT_GE(distanceToObstacles(world, world.crossing->way.back()), 0.6);
    std::size_t triangles = 0;
    for (const Surface& surface : world.scene.surfaces) {
      triangles += surface.triangles.size();
    }
    EXPECT_LT(triangles, 90'000U);
  }
}

TEST(World, ShowsItsSigns) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    expectPicturesInSight(makeWorld({}, seed));
  }
  expectPicturesInSight(makeWorld(flat(), 4));
}

TEST(World, LightsItsFloor) {
  const World world = makeWorld({}, 4);
  double sum = 0.0;
  for (const Polygon& room : world.rooms) {
    Vector2d p = Vector2d::Zero();
    for (const Vector2d& corner : room) {
      p += corner / static_cast<double>(room.size());
    }
    double light = 0.0;
    for (const Lamp& lamp : world.scene.lamps) {
      const Vector3d d = lamp.p_world - Vector3d(p.x(), p.y(), 0.0);
      const double cosine = d.normalized().z();
      light += lamp.power * 4.0 * lamp.half_size.prod() * cosine * cosine / d.squaredNorm();
    }
    EXPECT_GT(light, 0.4);
    EXPECT_LT(light, 2.5);
    sum += light / static_cast<double>(world.rooms.size());
  }
  EXPECT_NEAR(sum, 1.0, 0.25);
}

TEST(World, IsTheSameForTheSameSeedOnly) {
  const World one = makeWorld({}, 1);
  const World again = makeWorld({}, 1);
  const World two = makeWorld({}, 2);
  ASSERT_EQ(one.obstacles.size(), again.obstacles.size());
  for (std::size_t i = 0; i < one.obstacles.size(); ++i) {
    EXPECT_EQ(one.obstacles[i].a, again.obstacles[i].a);
  }
  ASSERT_EQ(one.scene.surfaces.size(), again.scene.surfaces.size());
  for (std::size_t i = 0; i < one.scene.surfaces.size(); ++i) {
    EXPECT_EQ(one.scene.surfaces[i].appearance.seed, again.scene.surfaces[i].appearance.seed);
  }
  EXPECT_NE(one.obstacles.size(), two.obstacles.size());
  EXPECT_NE(one.crossing->ramp_angle, two.crossing->ramp_angle);
}

TEST(World, FlatHasNothingToClimb) {
  const World world = makeWorld(flat(), 3);
  EXPECT_FALSE(world.crossing);
  EXPECT_TRUE(world.ramp_fields.empty());
  for (const Surface& surface : world.scene.surfaces) {
    for (const Surface::Vertex& vertex : surface.vertices) {
      ASSERT_TRUE(!surface.drivable || vertex.p_world.z() <= 0.031F);
    }
  }
}

TEST(World, RefusesScenariosThatCannotBe) {
  const auto errorWith = [](const WorldConfig& config) {
    return test::errorOf([&] { makeWorld(config, 1); });
  };
  const auto contains = [](const std::string& text, const char* part) {
    return text.find(part) != std::string::npos;
  };
  WorldConfig small;
  small.width = 5.0;
  small.depth = 4.0;
  EXPECT_TRUE(contains(errorWith(small), "too small for the crossing")) << errorWith(small);

  WorldConfig steep;
  steep.ramp_angle = {30.0, 41.0};
  EXPECT_TRUE(contains(errorWith(steep), "41 degrees is steeper than the 35")) << errorWith(steep);

  WorldConfig backwards;
  backwards.platform_height = {1.3, 1.1};
  EXPECT_TRUE(contains(errorWith(backwards), "world.platform_height")) << errorWith(backwards);

  WorldConfig inside = flat();
  inside.start_by_seed = false;
  inside.start = {0.2, 4.0, 0.0};
  EXPECT_TRUE(contains(errorWith(inside), "[0.2, 4] is 0.1")) << errorWith(inside);

  WorldConfig outside = inside;
  outside.start = {-3.0, 4.0, 0.0};
  EXPECT_TRUE(contains(errorWith(outside), "is in no room")) << errorWith(outside);

  WorldConfig wall = flat();
  wall.walls.push_back({{1.0, 1.0}, {40.0, 1.0}});
  EXPECT_TRUE(contains(errorWith(wall), "[40, 1] is outside")) << errorWith(wall);

  WorldConfig full = flat();
  full.victims = 20;
  full.width = full.depth = 4.0;
  EXPECT_TRUE(contains(errorWith(full), "20 victims")) << errorWith(full);
}

TEST(World, TakesStartAndWallsFromTheConfiguration) {
  common::Config source;
  for (const char* line :
       {"arena_sim.crossing=false", "arena_sim.ramp_fields=false", "arena_sim.size_variation=0",
        "arena_sim.start_by_seed=false", "arena_sim.walls=[{from: [0, 4], to: [0.5, 4]}]"}) {
    source.addOverride(line);
  }
  WorldConfig config = source.read<WorldConfig>("arena_sim");
  ASSERT_EQ(config.walls.size(), 1U);
  // Somewhere in the arena the robot can stand.
  std::string error = "none tried";
  for (double x = 1.0; x < 11.0 && !error.empty(); x += 0.5) {
    config.start = {x, 1.2, 0.5};
    error.clear();
    try {
      const World world = makeWorld(config, 1);
      // The corner of the arena, seen from the start.
      const Vector2d corner = common::Pose2{x, 1.2, 0.5}.inverse() * Vector2d::Zero();
      EXPECT_NEAR(distanceToObstacles(world, corner), 0.0, 0.03);
    } catch (const common::Error& e) {
      error = e.what();
    }
  }
  EXPECT_EQ(error, "");
}

}  // namespace
}  // namespace rubble::arena_sim
