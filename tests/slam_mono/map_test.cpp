#include "map/map.h"

#include <gmock/gmock.h>

#include <Eigen/LU>
#include <cmath>

namespace rubble::slam_mono {
namespace {

const OctaveScales kScales(1.2, 8, 0.0025);

/// Keyframes one metre apart that all see the same points, feature i showing point i.
class MapTest : public testing::Test {
 protected:
  MapTest() {
    for (int k = 0; k < 3; ++k) {
      orb::Features features;
      features.width = 640;
      features.height = 480;
      for (int i = 0; i < kPoints; ++i) {
        features.x.push_back(static_cast<float>(10 * i + k));
        features.y.push_back(200.0F);
        features.angle.push_back(0.0F);
        features.octave.push_back(2);
        features.descriptors.push_back({static_cast<std::uint64_t>(i), 0, 0, 0});
      }
      Keyframe keyframe;
      keyframe.map_id = 1;
      keyframe.frame = std::make_shared<const Frame>(k, features, Camera({}));
      keyframe.T_camera_mono.translation().x() = -k;
      map_.addKeyframe(std::move(keyframe));
    }
    for (std::uint32_t i = 0; i < kPoints; ++i) {
      MapPoint point;
      point.map_id = 1;
      point.p_mono_point = {0.1 * i, 0.0, 4.0};
      const PointId id = map_.addPoint(point);
      for (KeyframeId k = 0; k < 3; ++k) {
        map_.addObservation(id, k, i);
      }
      map_.refreshPoint(id, kScales);
    }
    for (KeyframeId k = 0; k < 3; ++k) {
      map_.refreshCovisibility(k);
    }
  }

  static constexpr int kPoints = 40;
  Map map_;
};

TEST_F(MapTest, UncertaintyOfAPointIsThatOfItsRays) {
  // Three cameras one metre apart see it four metres away: two independent errors across, each of the noise
  // times the distance, and along the line of sight what the directions' spread makes of it.
  const double sigma = kScales.angle(2);
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  const MapPoint& point = *map_.point(0);
  for (KeyframeId k = 0; k < 3; ++k) {
    const Eigen::Vector3d ray = point.p_mono_point - map_.keyframe(k)->p_mono_camera();
    information += (ray.squaredNorm() * Eigen::Matrix3d::Identity() - ray * ray.transpose()) /
                   (ray.squaredNorm() * ray.squaredNorm() * sigma * sigma);
  }
  const Eigen::Matrix3d covariance = information.inverse();
  const Eigen::Vector3d u = point.uncertainty;
  EXPECT_TRUE((covariance * u).isApprox(u.squaredNorm() * u, 1e-6));
  EXPECT_GT(u.squaredNorm(), 0.5 * covariance.trace());
  EXPECT_NEAR(u.norm(), 4.0 * 4.0 * sigma / std::sqrt(2.0), 0.1);
}

TEST_F(MapTest, UncertaintyEndsWhereNothingIsKnownOfTheDistance) {
  for (KeyframeId k = 0; k < 3; ++k) {
    map_.edit(k).T_camera_mono.translation().x() = 0.0;
  }
  map_.refreshPoint(0, kScales);
  EXPECT_NEAR(map_.point(0)->uncertainty.norm(), 40.0, 1e-6);
  EXPECT_NEAR(std::abs(map_.point(0)->uncertainty.normalized().z()), 1.0, 1e-6);
  map_.transform(1, Sim3(Eigen::Quaterniond(0.0, 1.0, 0.0, 0.0), Eigen::Vector3d::Zero(), 0.5), 2);
  EXPECT_NEAR(map_.point(0)->uncertainty.norm(), 20.0, 1e-6);
}

TEST_F(MapTest, UncertaintyOfAPointInACameraIsFinite) {
  map_.editPoint(0).p_mono_point = map_.keyframe(1)->p_mono_camera();
  map_.refreshPoint(0, kScales);
  EXPECT_TRUE(map_.point(0)->uncertainty.allFinite());
}

TEST_F(MapTest, SnapshotsDontSeeLaterEdits) {
  const auto snapshot = map_.snapshot();
  map_.edit(1).T_camera_mono.translation().x() = 7.0;
  map_.editPoint(3).p_mono_point.z() = 9.0;
  map_.erasePoint(5);
  map_.eraseKeyframe(2);
  EXPECT_EQ(snapshot->keyframe(1)->T_camera_mono.translation().x(), -1.0);
  EXPECT_EQ(snapshot->point(3)->p_mono_point.z(), 4.0);
  ASSERT_NE(snapshot->point(5), nullptr);
  EXPECT_EQ(snapshot->point(5)->observations.size(), 3U);
  ASSERT_NE(snapshot->keyframe(2), nullptr);
  EXPECT_EQ(map_.point(5), nullptr);
  EXPECT_EQ(map_.keyframe(2), nullptr);
  EXPECT_EQ(map_.point(3)->observations.size(), 2U);
}

TEST_F(MapTest, WhatIsSharedIsNotCopied) {
  const auto snapshot = map_.snapshot();
  map_.edit(1).scale = 2.0;
  EXPECT_EQ(snapshot->keyframe(0), map_.keyframe(0));
  EXPECT_NE(snapshot->keyframe(1), map_.keyframe(1));
}

TEST_F(MapTest, CovisibilityAndTreeFollowThePoints) {
  EXPECT_THAT(map_.neighbours(0, 10), testing::UnorderedElementsAre(1, 2));
  EXPECT_EQ(map_.keyframe(2)->parent, 0);
  map_.eraseKeyframe(0);
  EXPECT_EQ(map_.keyframe(1)->parent, kNoKeyframe);
  EXPECT_EQ(map_.keyframe(2)->parent, 1);
  EXPECT_THAT(map_.neighbours(1, 10), testing::ElementsAre(2));
}

TEST_F(MapTest, ReplacingHandsObservationsOver) {
  MapPoint point;
  point.map_id = 1;
  point.p_mono_point = {0.0, 0.0, 4.0};
  map_.eraseObservation(0, 2);
  const PointId twin = map_.addPoint(point);
  map_.addObservation(twin, 2, 0);
  map_.replacePoint(twin, 0);
  EXPECT_EQ(map_.point(twin), nullptr);
  EXPECT_EQ(map_.featureOf(0, 2), 0U);
  EXPECT_EQ(map_.keyframe(2)->points[0], 0U);
  EXPECT_EQ(map_.pointCount(), static_cast<std::size_t>(kPoints));
}

TEST_F(MapTest, APointSeenOnceGoes) {
  map_.eraseObservation(7, 0);
  ASSERT_NE(map_.point(7), nullptr);
  map_.eraseObservation(7, 1);
  EXPECT_EQ(map_.point(7), nullptr);
  EXPECT_EQ(map_.keyframe(2)->points[7], kNoPoint);
}

TEST_F(MapTest, ASimilarityMovesAllAndTellsItsScale) {
  const Eigen::Vector3d before = map_.keyframe(2)->T_camera_mono * map_.point(4)->p_mono_point;
  const Sim3 S_new_old(Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitY())), {1.0, 2.0, 3.0},
                       2.5);
  map_.transform(1, S_new_old, 9);
  const Eigen::Vector3d after = map_.keyframe(2)->T_camera_mono * map_.point(4)->p_mono_point;
  EXPECT_LT((after - 2.5 * before).norm(), 1e-12);
  EXPECT_EQ(map_.keyframe(2)->scale, 2.5);
  EXPECT_THAT(map_.mapIds(), testing::ElementsAre(9));
}

}  // namespace
}  // namespace rubble::slam_mono
