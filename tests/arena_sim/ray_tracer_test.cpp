#include "scene/ray_tracer.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "scene/mesh.h"

namespace rubble::arena_sim {
namespace {

using Eigen::Vector3d;

const Vector3d kSize(0.8, 0.5, 0.3);

common::Pose3 boxPose() {
  common::Pose3 T = common::Pose3::Identity();
  T.translate(Vector3d(0.3, -0.2, 1.0));
  T.rotate(Eigen::AngleAxisd(0.9, Vector3d(1.0, -0.5, 0.7).normalized()));
  return T;
}

Scene boxScene() {
  Scene scene;
  addBox(scene.surfaces, boxPose(), kSize, {}, false);
  return scene;
}

struct BoxHit {
  double distance = 0.0;
  double incidence = 0.0;
  double margin = 0.0;  // m from the box's edges; negative for a miss.
};

/// The box as three pairs of planes.
BoxHit castOnPlanes(const Vector3d& p_box, const Vector3d& d_box) {
  BoxHit hit{std::numeric_limits<double>::lowest(), 0.0, 0.0};
  double leave = std::numeric_limits<double>::max();
  for (int i = 0; i < 3; ++i) {
    const double a = (-0.5 * kSize[i] - p_box[i]) / d_box[i];
    const double b = (0.5 * kSize[i] - p_box[i]) / d_box[i];
    if (std::min(a, b) > hit.distance) {
      hit.distance = std::min(a, b);
      hit.incidence = std::abs(d_box[i]);
    }
    leave = std::min(leave, std::max(a, b));
  }
  hit.margin = leave - hit.distance;
  return hit;
}

TEST(RayTracer, AgreesWithPlanesOfABox) {
  const Scene scene = boxScene();
  const RayTracer tracer(scene);
  const common::Pose3 T_world_box = boxPose();
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  const auto anyVector = [&] { return Vector3d(normal(random), normal(random), normal(random)); };
  int hits = 0;
  int misses = 0;
  for (int i = 0; i < 5000; ++i) {
    const Vector3d p_box = 2.0 * anyVector().normalized();
    const Vector3d d_box = (0.3 * anyVector() - p_box).normalized();
    const BoxHit expected = castOnPlanes(p_box, d_box);
    if (std::abs(expected.margin) < 1e-4) {
      continue;  // Along an edge either answer is right.
    }
    const auto hit = tracer.cast(T_world_box * p_box, T_world_box.linear() * d_box);
    ASSERT_EQ(hit.has_value(), expected.margin > 0.0);
    (hit ? hits : misses) += 1;
    if (hit) {
      ASSERT_NEAR(hit->distance, expected.distance, 1e-5);
      ASSERT_NEAR(hit->incidence, expected.incidence, 1e-4);
      // The hit lies on the triangle that it names.
      const Surface& surface = scene.surfaces.at(hit->surface);
      const auto& triangle = surface.triangles.at(hit->triangle);
      const Surface::Vertex& corner = surface.vertices[triangle[0]];
      const Vector3d p_world = T_world_box * (p_box + hit->distance * d_box);
      ASSERT_NEAR((p_world - corner.p_world.cast<double>()).dot(corner.normal.cast<double>()), 0.0, 1e-5);
      ASSERT_LT((p_world - corner.p_world.cast<double>()).norm(), 1.5 * static_cast<double>(kMeshCell));
    }
  }
  EXPECT_GT(hits, 1000);
  EXPECT_GT(misses, 1000);
}

TEST(RayTracer, MeetsWallsFromBehind) {
  const RayTracer tracer(boxScene());
  const common::Pose3 T_world_box = boxPose();
  const auto hit = tracer.cast(T_world_box.translation(), T_world_box.linear().col(0));
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->distance, 0.4, 1e-5);
  EXPECT_NEAR(hit->incidence, 1.0, 1e-5);
}

TEST(RayTracer, SeesNothingBeyondTheLimit) {
  const RayTracer tracer(boxScene());
  const common::Pose3 T_world_box = boxPose();
  const Vector3d d_world = T_world_box.linear().col(1);
  EXPECT_TRUE(tracer.cast(T_world_box.translation(), d_world, 0.251));
  EXPECT_FALSE(tracer.cast(T_world_box.translation(), d_world, 0.249));
}

TEST(RayTracer, TakesInOnlyTheWantedAndKeepsTheirNumbers) {
  Scene scene = boxScene();
  scene.surfaces.back().drivable = true;
  const RayTracer tracer(scene, [](const Surface& surface) { return surface.drivable; });
  const common::Pose3 T_world_box = boxPose();
  int found = 0;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      const auto hit = tracer.cast(T_world_box.translation(), side * T_world_box.linear().col(axis));
      if (hit) {
        ++found;
        EXPECT_EQ(hit->surface, scene.surfaces.size() - 1);
      }
    }
  }
  EXPECT_EQ(found, 1);
}

}  // namespace
}  // namespace rubble::arena_sim
