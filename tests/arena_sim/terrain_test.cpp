#include "motion/terrain.h"

#include <gtest/gtest.h>

#include <cmath>

#include "motion/vehicle.h"
#include "scene/mesh.h"

namespace rubble::arena_sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

void addFloor(Scene& scene) {
  const Vector3d corners[] = {{-9.0, -9.0, 0.0}, {9.0, -9.0, 0.0}, {9.0, 9.0, 0.0}, {-9.0, 9.0, 0.0}};
  scene.surfaces.push_back(makePolygon(corners, {}, 3.0F));
  scene.surfaces.back().drivable = true;
}

/// A wedge over x = 1 .. 4 that rises with x.
void addRamp(Scene& scene, double slope) {
  const Vector2d outline[] = {{1.0, -2.0}, {4.0, -2.0}, {4.0, 2.0}, {1.0, 2.0}};
  const double tops[] = {0.0, 3.0 * slope, 3.0 * slope, 0.0};
  addPrism(scene.surfaces, outline, 0.0, tops, {}, true, 1.0F);
}

void addStep(Scene& scene, double x0, double height) {
  const Vector2d outline[] = {{x0, -2.0}, {x0 + 4.0, -2.0}, {x0 + 4.0, 2.0}, {x0, 2.0}};
  const double tops[] = {height, height, height, height};
  addPrism(scene.surfaces, outline, 0.0, tops, {}, true, 1.0F);
}

TEST(Terrain, IsTheHighestDrivableSurface) {
  Scene scene;
  addFloor(scene);
  addRamp(scene, 0.5);
  addBox(scene.surfaces, common::Pose3::Identity(), {1.0, 1.0, 2.0}, {}, false);
  const Terrain terrain(scene, {});
  EXPECT_NEAR(terrain.height({0.0, 0.0}), 0.0, 1e-5);
  EXPECT_NEAR(terrain.height({3.0, 0.3}), 1.0, 1e-5);
  EXPECT_EQ(terrain.height({20.0, 0.0}), Terrain::kNoGround);
}

TEST(Terrain, IsNotFeltThroughBarriers) {
  Scene scene;
  addFloor(scene);
  addStep(scene, 0.3, 1.0);
  const Terrain terrain(scene, {{{0.28, -2.0}, {0.28, 2.0}}});
  EXPECT_NEAR(terrain.height({0.35, 0.0}), 1.0, 1e-5);
  EXPECT_EQ(terrain.heightFrom({0.0, 0.0}, {0.35, 0.0}), Terrain::kNoGround);
  EXPECT_NEAR(restOn(terrain, {0.0, 0.0, 0.0}).translation().z(), 0.0, 1e-5);
}

TEST(Vehicle, StandsFlatOnTheFloor) {
  Scene scene;
  addFloor(scene);
  const common::Pose3 T = restOn(Terrain(scene, {}), {1.0, -2.0, 0.7});
  EXPECT_LT((T.matrix() - common::pose3FromPose2({1.0, -2.0, 0.7}).matrix()).norm(), 1e-5);
}

TEST(Vehicle, LiesOnARampAtAnyHeading) {
  const double slope = std::tan(0.5);
  Scene scene;
  addFloor(scene);
  addRamp(scene, slope);
  const Terrain terrain(scene, {});
  for (const double yaw : {0.0, 0.8, 1.6, 2.4, 3.1, -1.2}) {
    const common::Pose3 T = restOn(terrain, {2.5, 0.0, yaw});
    EXPECT_NEAR(T.translation().z(), 1.5 * slope, 1e-4) << yaw;
    EXPECT_NEAR((T.linear().col(2) - Vector3d(-std::sin(0.5), 0.0, std::cos(0.5))).norm(), 0.0, 1e-4) << yaw;
    EXPECT_NEAR(common::rpyFromRotation(T.linear()).yaw, yaw, 1e-9);
  }
}

TEST(Vehicle, LeansOnAStep) {
  Scene scene;
  addFloor(scene);
  constexpr double kHeight = 0.1;
  constexpr double kEdge = 0.15;
  addStep(scene, kEdge, kHeight);
  const common::Pose3 T = restOn(Terrain(scene, {}), {0.0, 0.0, 0.0});
  // The rear ends of the tracks on the floor, their undersides on the edge: between two of its points.
  const double pitch = common::rpyFromRotation(T.linear()).pitch;
  EXPECT_LT(pitch, -std::atan(kHeight / (0.3 + kEdge + 0.04)));
  EXPECT_GT(pitch, -std::atan(kHeight / (0.2 + kEdge)));
  // Nothing of it is under the ground by more than the points' distance allows.
  for (double x = -0.25; x <= 0.25; x += 0.01) {
    const Vector3d p = T * Vector3d(x, 0.2, 0.0);
    EXPECT_GT(p.z(), (p.x() > kEdge ? kHeight : 0.0) - 0.025) << x;
  }
}

TEST(Vehicle, StaysOnTopUntilItsCentreOfMassIsOverTheEdge) {
  Scene scene;
  addFloor(scene);
  addStep(scene, -4.0, 0.2);  // Ends at x = 0.
  const Terrain terrain(scene, {});
  EXPECT_NEAR(common::rpyFromRotation(restOn(terrain, {-0.1, 0.0, 0.0}).linear()).pitch, 0.0, 1e-4);
  EXPECT_NEAR(restOn(terrain, {-0.1, 0.0, 0.0}).translation().z(), 0.2, 1e-4);
  EXPECT_GT(common::rpyFromRotation(restOn(terrain, {0.1, 0.0, 0.0}).linear()).pitch, 0.3);
  EXPECT_NEAR(restOn(terrain, {0.6, 0.0, 0.0}).translation().z(), 0.0, 1e-4);
}

TEST(Vehicle, RidesOverAnEdgeWithoutJumps) {
  Scene scene;
  addFloor(scene);
  addRamp(scene, std::tan(0.55));
  std::vector<common::Pose2> plan;
  for (double x = 0.0; x < 6.0; x += 0.0015) {
    plan.push_back({x, 0.0, 0.0});
  }
  MotionConfig still;
  still.vibration = 0.0;
  const Terrain terrain(scene, {});
  const auto smooth = ride(terrain, plan, still, 1);
  const auto shaken = ride(terrain, plan, {}, 1);
  ASSERT_EQ(smooth.size(), plan.size());
  double highest = 0.0;
  double shaking = 0.0;
  for (std::size_t i = 1; i < smooth.size(); ++i) {
    ASSERT_LT((smooth[i].translation() - smooth[i - 1].translation()).norm(), 0.01);
    ASSERT_LT(std::acos(std::min(1.0, smooth[i].linear().col(0).dot(smooth[i - 1].linear().col(0)))), 0.02);
    highest = std::max(highest, smooth[i].translation().z());
    shaking = std::max(shaking, std::abs(smooth[i].linear()(2, 0) - shaken[i].linear()(2, 0)));
  }
  EXPECT_GT(highest, 1.5);
  EXPECT_GT(shaking, 0.001);
  EXPECT_LT(shaking, 0.02);
}

}  // namespace
}  // namespace rubble::arena_sim
