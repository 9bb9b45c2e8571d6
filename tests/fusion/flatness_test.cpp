#include "marks/flatness.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "marks/object_marks.h"

namespace rubble::fusion {
namespace {

using common::Pose3;
using Eigen::Vector3d;

constexpr double kPixel = 1.0 / 370.0;  // rad

/// Points with something to tell them by.
struct Thing {
  std::vector<Vector3d> points;
  std::vector<orb::Descriptor> descriptors;

  /// Points in a box of this size whose middle's front is at `p`, deep along x.
  static Thing make(const Vector3d& p, const Vector3d& size, int count = 60) {
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> side(-0.5, 0.5);
    Thing thing;
    for (int i = 0; i < count; ++i) {
      const Vector3d at(side(random) + 0.5, side(random), side(random));
      thing.points.push_back(p + size.cwiseProduct(at));
      thing.descriptors.push_back({random(), random(), random(), random()});
    }
    return thing;
  }
};

/// A level camera at p that looks along x.
Pose3 cameraAt(const Vector3d& p) {
  Pose3 T = Pose3::Identity();
  T.linear().col(0) = -Vector3d::UnitY();
  T.linear().col(1) = -Vector3d::UnitZ();
  T.linear().col(2) = Vector3d::UnitX();
  T.translation() = p;
  return T;
}

/// What a camera sees of a thing: corners half a pixel off, some bits of them different.
Sighting see(const Thing& thing, const Pose3& T_world_camera, std::mt19937_64& random) {
  std::normal_distribution<double> noise(0.0, 0.5 * kPixel);
  std::uniform_int_distribution<int> bit(0, 63);
  Sighting sighting;
  sighting.label = {"victim", "victim", ""};
  sighting.score = 0.9;
  Vector3d least = Vector3d::Constant(1e9);
  Vector3d most = -least;
  for (std::size_t i = 0; i < thing.points.size(); ++i) {
    Vector3d v = T_world_camera.inverse() * thing.points[i];
    v /= v.z();
    least = least.cwiseMin(v);
    most = most.cwiseMax(v);
    BoxFeature& feature = sighting.features.emplace_back();
    feature.direction = (v + Vector3d(noise(random), noise(random), 0.0)).normalized();
    feature.sigma = kPixel;
    feature.descriptor = thing.descriptors[i];
    for (std::uint64_t& word : feature.descriptor) {
      word ^= std::uint64_t{1} << bit(random);
    }
  }
  sighting.corners = {
      Vector3d(least.x(), least.y(), 1.0).normalized(), Vector3d(most.x(), least.y(), 1.0).normalized(),
      Vector3d(most.x(), most.y(), 1.0).normalized(), Vector3d(least.x(), most.y(), 1.0).normalized()};
  return sighting;
}

/// Twelve looks while the robot drives past, or towards it.
FlatnessCheck check(const Thing& thing, const Vector3d& step) {
  FlatnessCheck flatness;
  std::mt19937_64 random(3);
  for (int i = 0; i < 12; ++i) {
    const Pose3 T = cameraAt(i * step);
    FeatureView view{T.translation(), see(thing, T, random).features};
    for (BoxFeature& feature : view.features) {
      feature.direction = T.linear() * feature.direction;
    }
    flatness.add(std::move(view));
  }
  return flatness;
}

const Vector3d kPast(0.0, 0.08, 0.0);
const Thing kPoster = Thing::make({2.0, 0.4, 0.6}, {0.0, 0.4, 0.5});
const Thing kSitting = Thing::make({2.0, 0.4, 0.2}, {0.3, 0.4, 0.4});

TEST(Flatness, APosterIsFlatAndABodyIsNot) {
  EXPECT_TRUE(check(kPoster, kPast).isFlat());
  const FlatnessCheck body = check(kSitting, kPast);
  EXPECT_GT(body.points().size(), 20U);
  EXPECT_FALSE(body.isFlat());
}

TEST(Flatness, TheFrontOfOneThatLiesIsTooLowToBeFlat) {
  const FlatnessCheck body = check(Thing::make({2.0, 0.4, 0.06}, {0.03, 0.5, 0.12}), kPast);
  EXPECT_GT(body.points().size(), 20U);
  EXPECT_FALSE(body.isFlat());
}

TEST(Flatness, WithoutAChangeOfViewNothingIsFlat) {
  EXPECT_FALSE(check(kPoster, Vector3d::Zero()).isFlat());
  EXPECT_TRUE(check(kPoster, {0.0, 0.005, 0.0}).points().empty());
}

TEST(Flatness, ItsMemoryIsBounded) {
  FlatnessCheck flatness;
  std::mt19937_64 random(3);
  for (int i = 0; i < 100; ++i) {
    const Pose3 T = cameraAt({0.0, -0.02 * i, 0.0});
    flatness.add(
        {T.translation(), see(Thing::make({2.0, 0.4, 0.6}, {0.0, 0.4, 0.5}, 500), T, random).features});
  }
  EXPECT_LE(flatness.points().size(), 400U);
}

TEST(ObjectMarks, APosterThatWasTakenForAVictimStaysPending) {
  for (const bool is_flat : {true, false}) {
    ObjectMarks marks{MarksConfig()};
    std::mt19937_64 random(3);
    for (int i = 0; i < 12; ++i) {
      const Pose3 T = cameraAt(i * kPast);
      const std::vector<Sighting> seen = {see(is_flat ? kPoster : kSitting, T, random)};
      marks.addPicture({100'000 * (i + 1), T, true, 0, 7}, seen);
    }
    ASSERT_EQ(marks.marks().size(), 1U);
    EXPECT_EQ(marks.marks()[0].state, is_flat ? MarkState::kPending : MarkState::kConfirmed) << is_flat;
    EXPECT_EQ(marks.marks()[0].is_flat, is_flat);
    // Much later, straight ahead.
    for (int i = 0; i < 12; ++i) {
      const Pose3 T = cameraAt({0.06 * i, 0.4, 0.0});
      const std::vector<Sighting> seen = {see(is_flat ? kPoster : kSitting, T, random)};
      marks.addPicture({100'000'000 + 100'000 * i, T, true, 0, 7}, seen);
    }
    ASSERT_EQ(marks.marks().size(), 1U);
    EXPECT_EQ(marks.marks()[0].state, is_flat ? MarkState::kPending : MarkState::kConfirmed) << is_flat;
  }
}

}  // namespace
}  // namespace rubble::fusion
