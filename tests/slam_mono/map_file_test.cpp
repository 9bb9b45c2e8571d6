#include "map/map_file.h"

#include <gmock/gmock.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <limits>

#include "common/files.h"
#include "support/error_text.h"
#include "synthetic_mission.h"
#include "synthetic_scenes.h"

namespace rubble::slam_mono {
namespace {

using testing::HasSubstr;

constexpr int kLevels = 8;
constexpr std::uint32_t kFeatures = 20;

std::string parseError(std::span<const std::uint8_t> bytes) {
  return test::errorOf([&] { parseMap(bytes, arenaCamera(), kLevels); });
}

std::vector<std::uint8_t> withRightChecksum(std::vector<std::uint8_t> bytes) {
  const auto content = std::span(bytes).first(bytes.size() - 4);
  const std::uint32_t crc = common::crc32(content);
  std::memcpy(bytes.data() + content.size(), &crc, sizeof crc);
  return bytes;
}

/// Keyframes 0, 2, 3 in map 1 and 4 in map 2; points with gaps.
class SmallMapTest : public testing::Test {
 protected:
  SmallMapTest() {
    for (int i = 0; i < 5; ++i) {
      addKeyframe(i < 4 ? 1 : 2);
    }
    const OctaveScales scales(1.2, kLevels, 0.0025);
    for (std::uint32_t i = 0; i < kFeatures; ++i) {
      MapPoint point;
      point.map_id = 1;
      point.p_mono_point = dice_.vector(1.0) + Eigen::Vector3d(0.0, 0.0, 5.0);
      point.first = 3;
      const PointId id = map_.addPoint(point);
      for (const KeyframeId k : {0, 1, 2, 3}) {
        map_.addObservation(id, k, (i + 3 * static_cast<std::uint32_t>(k)) % kFeatures);
      }
      map_.refreshPoint(id, scales);
    }
    map_.revision = 7;
    for (const KeyframeId k : {0, 1, 2, 3}) {
      map_.refreshCovisibility(k);
    }
    map_.edit(0).loops = {3};
    map_.edit(3).loops = {0};
    map_.eraseKeyframe(1);
    map_.erasePoint(0);
    map_.erasePoint(7);
    map_.erasePoint(kFeatures - 1);
  }

  std::shared_ptr<const Frame> frame() {
    orb::Features features;
    features.width = 640;
    features.height = 480;
    for (std::size_t i = 0; i < kFeatures; ++i) {
      const Eigen::Vector2d pixel = dice_.pixel(arenaCamera());
      features.x.push_back(static_cast<float>(pixel.x()));
      features.y.push_back(static_cast<float>(pixel.y()));
      features.angle.push_back(0.1F * static_cast<float>(i));
      features.octave.push_back(static_cast<std::uint8_t>(i % kLevels));
      features.descriptors.push_back(randomDescriptor(dice_));
    }
    return std::make_shared<const Frame>(1'000'000, std::move(features), arenaCamera());
  }

  void addKeyframe(int map_id) {
    Keyframe keyframe;
    keyframe.map_id = map_id;
    keyframe.frame = frame();
    keyframe.T_camera_mono = dice_.pose(0.5, 0.2);
    keyframe.scale = dice_.uniform(0.5, 2.0);
    map_.addKeyframe(std::move(keyframe));
  }

  /// What parsing says about the map after `harm`.
  std::string errorAfter(const std::function<void(Map&)>& harm) {
    Map map = *map_.snapshot();
    map.snapshot();  // makes edits copy
    harm(map);
    return parseError(serialiseMap(map));
  }
  /// The same features but one.
  static void spoil(Keyframe& keyframe, const std::function<void(orb::Features&)>& harm) {
    Frame frame = *keyframe.frame;
    harm(frame.features);
    keyframe.frame = std::make_shared<const Frame>(std::move(frame));
  }

  Dice dice_{5};
  Map map_;
};

TEST_F(SmallMapTest, ComesBackAsItWas) {
  const auto bytes = serialiseMap(map_);
  Map map = parseMap(bytes, arenaCamera(), kLevels);
  EXPECT_EQ(serialiseMap(map), bytes);
  EXPECT_EQ(map.keyframes(), (std::vector<KeyframeId>{0, 2, 3, 4}));
  EXPECT_EQ(map.points(), map_.points());
  EXPECT_EQ(map.keyframeCount(), map_.keyframeCount());
  EXPECT_EQ(map.pointCount(), map_.pointCount());
  EXPECT_EQ(map.revision, 7);
  for (const KeyframeId id : map.keyframes()) {
    const Keyframe& is = *map.keyframe(id);
    const Keyframe& was = *map_.keyframe(id);
    EXPECT_EQ(is.points, was.points);
    EXPECT_EQ(is.covisible, was.covisible);
    EXPECT_EQ(is.parent, was.parent);
    EXPECT_EQ(is.frame->bearings, was.frame->bearings);
    std::vector<std::uint32_t> found;
    is.frame->grid.find(is.frame->features, is.frame->pixel(4), 1.0, 0, kLevels, found);
    EXPECT_THAT(found, testing::Contains(4U));
  }
  // What is added next gets the same ids as before.
  EXPECT_EQ(map.addPoint({}), map_.addPoint({}));
  EXPECT_EQ(map.nextKeyframeId(), map_.nextKeyframeId());
}

TEST_F(SmallMapTest, EmptyMapComesBack) {
  const auto bytes = serialiseMap(Map{});
  EXPECT_EQ(serialiseMap(parseMap(bytes, arenaCamera(), kLevels)), bytes);
}

TEST_F(SmallMapTest, NamesWhatIsWrong) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto keyframe = [&](const std::function<void(Keyframe&)>& harm) {
    return errorAfter([&](Map& map) { harm(map.edit(2)); });
  };
  EXPECT_THAT(keyframe([](Keyframe& k) { k.map_id = 0; }), HasSubstr("keyframe 2: map id"));
  EXPECT_THAT(keyframe([&](Keyframe& k) { k.scale = nan; }), HasSubstr("scale"));
  EXPECT_THAT(keyframe([&](Keyframe& k) { k.T_camera_mono.translation().y() = nan; }),
              HasSubstr("not a pose"));
  EXPECT_THAT(keyframe([&](Keyframe& k) { k.T_camera_mono.linear() *= 1.01; }), HasSubstr("not a pose"));
  EXPECT_THAT(keyframe([&](Keyframe& k) { k.parent = 1; }), HasSubstr("parent"));
  EXPECT_THAT(keyframe([&](Keyframe& k) { k.parent = 4; }), HasSubstr("parent"));
  EXPECT_THAT(keyframe([&](Keyframe& k) { k.parent = 2; }), HasSubstr("parent"));
  EXPECT_THAT(keyframe([&](Keyframe& k) { k.loops = {17}; }), HasSubstr("loop"));
  EXPECT_THAT(keyframe([&](Keyframe& k) { k.covisible.front().first = 1; }), HasSubstr("neighbour"));
  EXPECT_THAT(keyframe([&](Keyframe& k) { --k.covisible.front().second; }), HasSubstr("alike"));
  EXPECT_THAT(keyframe([&](Keyframe& k) { k.covisible.push_back(k.covisible.front()); }), HasSubstr("twice"));
  EXPECT_THAT(errorAfter([](Map& map) {
                map.edit(0).parent = 3;
                map.edit(3).parent = 0;
              }),
              HasSubstr("ancestor"));

  const auto features = [&](const std::function<void(orb::Features&)>& harm) {
    return keyframe([&](Keyframe& k) { spoil(k, harm); });
  };
  EXPECT_THAT(features([](orb::Features& f) { f.width = 320; }), HasSubstr("size"));
  EXPECT_THAT(features([](orb::Features& f) { f.x[3] = 640.5F; }), HasSubstr("outside"));
  EXPECT_THAT(features([](orb::Features& f) { f.y[3] = std::nanf(""); }), HasSubstr("outside"));
  EXPECT_THAT(features([](orb::Features& f) { f.angle[3] = HUGE_VALF; }), HasSubstr("orientation"));
  EXPECT_THAT(features([](orb::Features& f) { f.octave[3] = kLevels; }), HasSubstr("octave"));

  const auto point = [&](const std::function<void(MapPoint&)>& harm) {
    return errorAfter([&](Map& map) { harm(map.editPoint(5)); });
  };
  EXPECT_THAT(point([](MapPoint& p) { p.map_id = 2; }),
              HasSubstr("point 5: seen by a keyframe of another map"));
  EXPECT_THAT(point([&](MapPoint& p) { p.p_mono_point.x() = nan; }), HasSubstr("not finite"));
  EXPECT_THAT(point([&](MapPoint& p) { p.uncertainty.y() = nan; }), HasSubstr("not finite"));
  EXPECT_THAT(point([&](MapPoint& p) { p.normal.z() = nan; }), HasSubstr("not finite"));
  EXPECT_THAT(point([](MapPoint& p) { p.max_distance = 0.5 * p.min_distance; }), HasSubstr("distances"));
  EXPECT_THAT(point([](MapPoint& p) { p.reference = 4; }), HasSubstr("reference"));
  EXPECT_THAT(point([](MapPoint& p) { p.first = 5; }), HasSubstr("impossible keyframe"));
  EXPECT_THAT(point([](MapPoint& p) { p.found = -1; }), HasSubstr("negative"));
  EXPECT_THAT(point([](MapPoint& p) { p.observations.clear(); }), HasSubstr("reference"));
  EXPECT_THAT(point([](MapPoint& p) { p.observations[0].keyframe = 1; }), HasSubstr("does not exist"));
  EXPECT_THAT(point([](MapPoint& p) { p.observations[0].feature = kFeatures; }), HasSubstr("does not have"));
  EXPECT_THAT(point([](MapPoint& p) { p.observations[0].feature = 6; }), HasSubstr("another point"));
  EXPECT_THAT(point([](MapPoint& p) {
                p.observations[1] = p.observations[0];
                p.observations[1].feature = 0;
              }),
              HasSubstr("twice"));
}

TEST_F(SmallMapTest, TruncatedOrDamagedBytesAreRefused) {
  const auto bytes = serialiseMap(map_);
  for (std::size_t size = 0; size < bytes.size(); size += 13) {
    EXPECT_THAT(parseError(std::span(bytes).first(size)), testing::StartsWith("monocular map: ")) << size;
    auto shorter = bytes;
    shorter.resize(size);
    if (size > 12) {
      EXPECT_THAT(parseError(withRightChecksum(shorter)), testing::StartsWith("monocular map: ")) << size;
    }
  }
  for (std::size_t i = 0; i < bytes.size(); i += 17) {
    auto damaged = bytes;
    damaged[i] ^= 4U;
    EXPECT_THAT(parseError(damaged), testing::StartsWith("monocular map: ")) << i;
  }
  auto longer = bytes;
  longer.push_back(0);
  EXPECT_THAT(parseError(withRightChecksum(longer)), HasSubstr("more than belongs"));
  auto newer = bytes;
  newer[7] = static_cast<std::uint8_t>(kMapMagic[7] + 1);
  EXPECT_THAT(parseError(newer), HasSubstr("version"));
}

TEST_F(SmallMapTest, WhateverPassesIsWhatWasWritten) {
  const auto bytes = serialiseMap(map_);
  int refused = 0;
  constexpr int kTrials = 5000;
  for (int i = 0; i < kTrials; ++i) {
    auto damaged = bytes;
    const auto at = static_cast<std::size_t>(dice_.uniform(8.0, static_cast<double>(bytes.size() - 4)));
    damaged[at] = static_cast<std::uint8_t>(dice_.uniform(0.0, 256.0));
    damaged = withRightChecksum(std::move(damaged));
    try {
      EXPECT_EQ(serialiseMap(parseMap(damaged, arenaCamera(), kLevels)), damaged) << at;
    } catch (const common::Error&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, kTrials / 20);
}

TEST(MapFileTest, AMissionsMapComesBack) {
  const SyntheticScene scene = makeRoom(3);
  const FloorPath path(scene.line, scene.closed, 0.8);
  Route route(path.at(0.0), 15.0, 3);
  route.drive(path, 0.0, 5.0);
  Mission mission(scene.world, arenaCamera(), {}, 3);
  mission.follow(route.poses());
  const auto map = mission.map();
  ASSERT_GT(map->keyframeCount(), 10U);
  ASSERT_LT(map->pointCount(), map->nextPointId());
  const auto bytes = serialiseMap(*map);
  EXPECT_EQ(serialiseMap(parseMap(bytes, arenaCamera(), kLevels)), bytes);
}

}  // namespace
}  // namespace rubble::slam_mono
