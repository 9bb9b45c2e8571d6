#include "mono_map_publisher.h"

#include <gtest/gtest.h>

#include <map>
#include <set>

#include "lcm_io/conversions.h"

namespace rubble::slam_mono {
namespace {

using common::Pose3;

constexpr std::size_t kFeatures = 50;
constexpr int kMostBytes = 60'000 + 100;

/// What somebody knows who has heard the messages.
struct Listener {
  std::map<std::int32_t, rubble::mono_keyframe_t> keyframes;
  std::map<std::int64_t, float> points;
  std::vector<common::Utime> frames;
  std::vector<rubble::mono_removed_keyframe_t> removed;

  void hear(const rubble::mono_map_t& message) {
    EXPECT_LE(message.getEncodedSize(), kMostBytes);
    for (const auto& k : message.keyframes) {
      keyframes[k.id] = k;
    }
    for (const auto& k : message.removed) {
      keyframes.erase(k.id);
      removed.push_back(k);
    }
    for (const auto& p : message.points) {
      points[p.id] = p.p_mono_point[0];
    }
    for (const auto id : message.erased_points) {
      points.erase(id);
    }
    for (const auto& f : message.frames) {
      frames.push_back(f.utime);
    }
  }
};

class MonoMapPublisherTest : public testing::Test {
 protected:
  void grow(int keyframes, int points_each) {
    for (int i = 0; i < keyframes; ++i) {
      orb::Features features;
      features.width = 640;
      features.height = 480;
      features.x.assign(kFeatures, 320.0F);
      features.y.assign(kFeatures, 240.0F);
      features.angle.assign(kFeatures, 0.0F);
      features.octave.assign(kFeatures, 0);
      features.descriptors.resize(kFeatures);
      Keyframe keyframe;
      keyframe.map_id = 1;
      keyframe.frame = std::make_shared<const Frame>(++now_, std::move(features), camera_);
      keyframe.T_camera_mono = common::pose3FromPose2({-0.1 * static_cast<double>(now_), 0.3, 0.01});
      keyframe.parent = map_.nextKeyframeId() - 1;
      const KeyframeId id = map_.addKeyframe(keyframe);
      for (int p = 0; p < points_each; ++p) {
        MapPoint point;
        point.map_id = 1;
        point.p_mono_point = {static_cast<double>(p), static_cast<double>(id), 5.0};
        map_.addPoint(point);
      }
    }
  }
  void track(KeyframeId keyframe) {
    FrameResult result;
    result.utime = ++now_;
    result.keyframe_id = keyframe;
    publisher_.add(result, map_.snapshot());
  }

  const Camera camera_{common::RobotConfig::Intrinsics{}};
  Map map_;
  MonoMapPublisher publisher_;
  Listener listener_;
  common::Utime now_ = 0;
};

TEST_F(MonoMapPublisherTest, WhatIsUrgentGoesFirstInAsManyMessagesAsItNeeds) {
  grow(2000, 5);
  for (int i = 0; i < 3000; ++i) {
    track(0);
  }
  int messages = 0;
  while (publisher_.behind()) {
    listener_.hear(publisher_.next(now_));
    ASSERT_LT(++messages, 12);
  }
  EXPECT_EQ(listener_.keyframes.size(), 2000U);
  ASSERT_EQ(listener_.frames.size(), 3000U);
  EXPECT_TRUE(std::is_sorted(listener_.frames.begin(), listener_.frames.end()));
  EXPECT_EQ(publisher_.next(now_).nframes, 0);
}

TEST_F(MonoMapPublisherTest, ALateJoinerHearsTheWholeMap) {
  grow(200, 100);
  track(0);
  Listener early;
  for (int i = 0; i < 20; ++i) {
    early.hear(publisher_.next(now_));
  }
  EXPECT_EQ(early.points.size(), 20'000U);
  for (int i = 0; i < 20'000 / 500 + 1; ++i) {
    listener_.hear(publisher_.next(now_));
  }
  EXPECT_EQ(listener_.keyframes.size(), 200U);
  EXPECT_EQ(listener_.points.size(), 20'000U);
}

TEST_F(MonoMapPublisherTest, MovedAndErasedPointsAreTold) {
  grow(3, 100);
  track(0);
  listener_.hear(publisher_.next(now_));
  map_.editPoint(7).p_mono_point.x() = 77.0;
  map_.erasePoint(8);
  track(0);
  listener_.hear(publisher_.next(now_));
  EXPECT_EQ(listener_.points.size(), 299U);
  EXPECT_FLOAT_EQ(listener_.points.at(7), 77.0F);
}

TEST_F(MonoMapPublisherTest, ARemovedKeyframeHangsOnItsParent) {
  grow(4, 0);
  track(2);
  const Pose3 T_parent_camera = map_.keyframe(1)->T_camera_mono * map_.keyframe(2)->T_camera_mono.inverse();
  map_.edit(1).scale = 1.5;
  map_.edit(2).scale = 2.0;
  track(2);
  // Parent and all move on, then the keyframe goes before a message tells of it.
  map_.eraseKeyframe(2);
  map_.transform(1, Sim3(common::pose3FromPose2({3.0, 2.0, 1.0})), 1);
  track(1);
  listener_.hear(publisher_.next(now_));
  EXPECT_EQ(listener_.keyframes.size(), 3U);
  ASSERT_EQ(listener_.removed.size(), 1U);
  const auto& removed = listener_.removed[0];
  EXPECT_EQ(removed.id, 2);
  EXPECT_EQ(removed.parent, 1);
  EXPECT_EQ(removed.parent_scale, 1.5);
  EXPECT_EQ(removed.scale, 2.0);
  EXPECT_TRUE(lcm_io::poseFromMessage(removed.p_parent_camera, removed.q_parent_camera)
                  .isApprox(T_parent_camera, 1e-9));
}

}  // namespace
}  // namespace rubble::slam_mono
