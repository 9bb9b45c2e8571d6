#include "truth/object_sight.h"

#include <gtest/gtest.h>

#include <numbers>

#include "scene/mesh.h"

namespace rubble::arena_sim {
namespace {

using common::Pose3;
using Eigen::Vector3d;

constexpr double kDistance = 1.0;

/// A picture of 0.2 m in the middle of the view of a camera 1 m away, focal length 370 pixels.
class ObjectSightTest : public testing::Test {
 protected:
  ObjectSightTest() {
    object_.size = {0.2, 0.2};
    object_.bounds = {Vector3d(-0.1, -0.1, 0.0), Vector3d(0.1, 0.1, 0.0)};
    scene_.surfaces.push_back(makePicture(object_.T_world_object, object_.size, {}));
    // In front of the picture, looking at it.
    T_world_camera_.linear().diagonal() << 1.0, -1.0, -1.0;
    T_world_camera_.translation().z() = kDistance;
  }

  std::optional<double> size() const { return ObjectSight(scene_, {}).sizeOf(object_, T_world_camera_); }

  /// The camera goes round the object, which stays in the middle.
  void turn(double angle) { T_world_camera_ = Eigen::AngleAxisd(angle, Vector3d::UnitY()) * T_world_camera_; }

  void cover(double from_x, double to_x) {
    addBox(scene_.surfaces, Pose3(Eigen::Translation3d(0.5 * (from_x + to_x), 0.0, 0.1)),
           {to_x - from_x, 1.0, 0.02}, {}, false);
  }

  Scene scene_;
  WorldObject object_;
  Pose3 T_world_camera_ = Pose3::Identity();
};

TEST_F(ObjectSightTest, SizeIsThatOfTheOutline) {
  EXPECT_NEAR(size().value(), 74.0, 1e-6);
  turn(std::numbers::pi / 3.0);
  EXPECT_NEAR(size().value(), 74.0 * std::sqrt(0.5), 1.0);
}

TEST_F(ObjectSightTest, NotFromTheSideOrBehind) {
  turn(1.2);
  EXPECT_TRUE(size());
  turn(0.05);
  EXPECT_FALSE(size());
  turn(std::numbers::pi - 1.25);
  EXPECT_FALSE(size());
}

TEST_F(ObjectSightTest, AllOfItMustBeInThePicture) {
  T_world_camera_.translation().x() = 0.7;
  EXPECT_TRUE(size());
  T_world_camera_.translation().x() = 0.8;
  EXPECT_FALSE(size());
  T_world_camera_.translation().z() = -kDistance;
  EXPECT_FALSE(size());
}

TEST_F(ObjectSightTest, WhatStandsBeforeItHidesIt) {
  cover(0.2, 0.4);
  EXPECT_TRUE(size());
  cover(0.05, 0.2);
  EXPECT_FALSE(size());
}

TEST_F(ObjectSightTest, AVictimMayBeHalfHidden) {
  object_.bounds.extend(Vector3d(0.0, 0.0, 0.05));
  EXPECT_NEAR(size().value(), 0.2 * 370.0 / (kDistance - 0.05), 1e-6);
  cover(0.05, 0.2);
  EXPECT_TRUE(size());
  cover(-0.05, 0.2);
  EXPECT_FALSE(size());
}

}  // namespace
}  // namespace rubble::arena_sim
