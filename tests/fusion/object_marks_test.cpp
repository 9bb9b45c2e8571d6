#include "marks/object_marks.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "common/error.h"
#include "marks/lidar_range.h"

namespace rubble::fusion {
namespace {

using common::Pose3;
using Eigen::Vector3d;

constexpr common::Utime kPeriod = 100'000;

/// A camera at p that looks along a heading, level.
Pose3 cameraAt(const Vector3d& p, double yaw) {
  Pose3 T = Pose3::Identity();
  const Vector3d forward(std::cos(yaw), std::sin(yaw), 0.0);
  T.linear().col(2) = forward;
  T.linear().col(1) = -Vector3d::UnitZ();
  T.linear().col(0) = T.linear().col(1).cross(forward);
  T.translation() = p;
  return T;
}

/// A face of 0.2 m by 0.2 m at p that looks towards -x.
Pose3 faceAt(const Vector3d& p) {
  Pose3 T = Pose3::Identity();
  T.linear().col(0) = -Vector3d::UnitY();
  T.linear().col(1) = Vector3d::UnitZ();
  T.linear().col(2) = -Vector3d::UnitX();
  T.translation() = p;
  return T;
}

constexpr double kSide = 0.2;

class Robot {
 public:
  /// What its camera sees of a face, a pixel of noise or so.
  Sighting see(const Pose3& T_world_camera, const Pose3& T_world_object, const std::string& name,
               double noise = 0.0) {
    Sighting sighting;
    sighting.label = {name, "hazard", ""};
    sighting.score = 0.8;
    std::normal_distribution<double> jitter(0.0, noise);
    const Vector3d corners[] = {{-1, 1, 0}, {1, 1, 0}, {1, -1, 0}, {-1, -1, 0}};
    for (std::size_t i = 0; i < 4; ++i) {
      Vector3d p = T_world_camera.inverse() * (T_world_object * Vector3d(kSide / 2.0 * corners[i]));
      p /= p.z();
      sighting.corners[i] = Vector3d(p.x() + jitter(random_), p.y() + jitter(random_), 1.0).normalized();
    }
    return sighting;
  }

  PicturePlace place(const Pose3& T_world_camera, bool on_level = true, double sigma = 0.0,
                     std::int32_t level = 0) {
    utime_ += kPeriod;
    return {utime_, T_world_camera, on_level, level, 7, sigma};
  }

 private:
  std::mt19937 random_{5};
  common::Utime utime_ = 0;
};

const Pose3 kFace = faceAt({3.0, 0.5, 0.6});

Pose3 poseOnTheWay(int picture) { return cameraAt({0.05 * picture, -0.02 * picture, 0.4}, 0.1); }

TEST(Sighting, GeometryOfAFaceIsExact) {
  Robot robot;
  const Pose3 T_world_camera = cameraAt({0.0, -1.0, 0.2}, 0.3);
  Sighting sighting = robot.see(T_world_camera, kFace, "poison");
  const Pose3 T_camera_object = T_world_camera.inverse() * kFace;
  EXPECT_LT((centreBearing(sighting.corners) - T_camera_object.translation().normalized()).norm(), 1e-9);
  const auto R = faceAttitude(sighting.corners);
  ASSERT_TRUE(R);
  EXPECT_LT((*R - T_camera_object.linear()).norm(), 1e-6);
  EXPECT_FALSE(rangeBySize(sighting));
  sighting.width = sighting.height = kSide;
  EXPECT_NEAR(rangeBySize(sighting)->range, T_camera_object.translation().norm(), 1e-6);
  std::swap(sighting.corners[1], sighting.corners[3]);
  EXPECT_FALSE(faceAttitude(sighting.corners)) << "mirrored: seen from behind";
}

TEST(LidarRange, IsTheWallsThatStandsBelow) {
  RangeScan scan;
  scan.first_angle = -M_PI / 2.0;
  scan.angle_step = M_PI / 720.0;
  for (int i = 0; i <= 720; ++i) {
    const double angle = scan.first_angle + i * scan.angle_step;
    scan.ranges.push_back(std::cos(angle) > 0.1 ? static_cast<float>(3.0 / std::cos(angle)) : NAN);
  }
  Pose3 T_world_lidar = Pose3::Identity();
  T_world_lidar.translation().z() = 0.3;
  const Vector3d camera(0.2, 0.0, 0.4);
  const Vector3d object(3.0, 0.7, 0.9);
  const auto range = rangeAlong(camera, (object - camera).normalized(), scan, T_world_lidar);
  ASSERT_TRUE(range);
  EXPECT_NEAR(range->range, (object - camera).norm(), 0.05);
  EXPECT_LT(range->sigma, 0.4);
  EXPECT_FALSE(rangeAlong(camera, -Vector3d::UnitX(), scan, T_world_lidar)) << "nothing behind";
  EXPECT_FALSE(rangeAlong(camera, Vector3d(0.1, 0.0, 1.0).normalized(), scan, T_world_lidar)) << "too steep";
}

TEST(ObjectMarks, OneObjectIsOneMarkAtItsPlace) {
  Robot robot;
  ObjectMarks marks{{}};
  for (int i = 0; i < 30; ++i) {
    const Pose3 T = poseOnTheWay(i);
    const Sighting sighting = robot.see(T, kFace, "poison", 0.003);
    marks.addPicture(robot.place(T), std::span(&sighting, 1));
  }
  ASSERT_EQ(marks.marks().size(), 1);
  const Mark& mark = marks.marks().front();
  EXPECT_EQ(mark.state, MarkState::kConfirmed);
  EXPECT_EQ(mark.views, 30);
  EXPECT_LT((mark.position.p_world - kFace.translation()).norm(), 0.1);
  EXPECT_LT(Eigen::AngleAxisd(mark.R_world_object.transpose() * kFace.linear()).angle(), 0.3);
  EXPECT_LE(mark.kept_views.size(), 24);
}

TEST(ObjectMarks, TheLidarsRangePlacesWhatIsSeenFromOnePlace) {
  Robot robot;
  ObjectMarks marks{{}};
  const Pose3 T = poseOnTheWay(0);
  for (int i = 0; i < 5; ++i) {
    Sighting sighting = robot.see(T, kFace, "poison");
    sighting.lidar = RangeMeasurement{(kFace.translation() - T.translation()).norm(), 0.05};
    marks.addPicture(robot.place(T), std::span(&sighting, 1));
  }
  ASSERT_EQ(marks.marks().size(), 1);
  EXPECT_EQ(marks.marks().front().state, MarkState::kConfirmed);
  EXPECT_LT((marks.marks().front().position.p_world - kFace.translation()).norm(), 0.05);
}

TEST(ObjectMarks, AWrongRangeMakesNoSecondMarkOfACode) {
  ObjectMarks marks{{}};
  Robot robot;
  const auto code = [&](int picture) {
    Sighting sighting = robot.see(poseOnTheWay(picture), kFace, "qr", 1e-3);
    sighting.label = {"qr", "qr", "room 7"};
    return sighting;
  };
  for (int i = 0; i < 30; ++i) {
    const Sighting sighting = code(i);
    marks.addPicture(robot.place(poseOnTheWay(i)), std::span(&sighting, 1));
  }
  // The LiDAR sees a box before the wall.
  for (int i = 30; i < 33; ++i) {
    Sighting sighting = code(i);
    sighting.lidar = RangeMeasurement{0.6, 0.05};
    marks.addPicture(robot.place(poseOnTheWay(i)), std::span(&sighting, 1));
  }
  ASSERT_EQ(marks.marks().size(), 1U);
  EXPECT_LT((marks.marks()[0].position.p_world - kFace.translation()).norm(), 0.1);
}

TEST(ObjectMarks, TheWayUpARampMendsTheRangeOfItsSlope) {
  for (const double drift : {0.03, 0.5}) {
    ObjectMarks marks{{}};
    Robot robot;
    const Pose3 label = faceAt({2.0, 0.8, 1.2});
    for (int i = 0; i < 30; ++i) {
      const bool on_level = i < 6;
      const Pose3 camera = cameraAt({0.03 * i, 0.0, 0.3 + 0.01 * i}, 0.3);
      Sighting sighting = robot.see(camera, label, "poison", 0.003);
      if (on_level) {
        sighting.lidar = RangeMeasurement{0.9, 0.23};
      }
      marks.addPicture(robot.place(camera, on_level, on_level ? 0.01 : drift), std::span(&sighting, 1));
    }
    const Mark& mark = marks.marks().front();
    const double error = (mark.position.p_world - label.translation()).norm();
    if (drift < 0.1) {
      EXPECT_LT(error, 0.15);
      EXPECT_EQ(marks.marks().size(), 1U);
    } else {
      EXPECT_GT(error, 0.5) << "a pose that has drifted that far changes nothing";
    }
    EXPECT_TRUE(mark.on_level) << "corrections of the monocular map do not move it";
  }
}

TEST(ObjectMarks, StayWithTheLevelThatSawThemFirst) {
  ObjectMarks marks{{}};
  Robot robot;
  for (int i = 0; i < 30; ++i) {
    const int level = i < 12 ? 0 : 1;
    const Pose3 camera = cameraAt({0.0, 0.5 - 0.05 * i, 0.4}, 0.1);
    const Sighting sighting = robot.see(camera, kFace, "poison", 0.001);
    // The other level's grid lies 0.2 m aside.
    const Pose3 told = Pose3(Eigen::Translation3d(0.0, 0.2 * level, 0.0)) * camera;
    marks.addPicture(robot.place(told, true, level == 0 ? 0.01 : 0.2, level), std::span(&sighting, 1));
  }
  ASSERT_EQ(marks.marks().size(), 1U);
  EXPECT_EQ(marks.marks().front().level, 0);
  EXPECT_LT((marks.marks().front().position.p_world - kFace.translation()).norm(), 0.05);
}

TEST(ObjectMarks, OneThatWasSeenTwiceBelongsToTheLevelOfTheSightingInH) {
  const auto seen = [&](bool on_level, std::int32_t level) {
    ObjectMarks marks{{}};
    Robot robot;
    for (int i = 0; i < 10; ++i) {
      const Sighting sighting = robot.see(poseOnTheWay(i), kFace, "poison");
      marks.addPicture(robot.place(poseOnTheWay(i), on_level, 0.1, level), std::span(&sighting, 1));
    }
    return marks.marks().front();
  };
  std::vector<Mark> both = {seen(false, 0), seen(true, 1)};
  both[1].id = 2;
  ObjectMarks marks{{}};
  marks.restore(both, 3);
  Robot robot;
  const Sighting another = robot.see(poseOnTheWay(0), kFace, "corrosive");
  marks.addPicture(robot.place(poseOnTheWay(0), false, 1.0), std::span(&another, 1));
  ASSERT_EQ(marks.marks().size(), 2U);
  EXPECT_EQ(marks.marks().front().id, 1);
  EXPECT_TRUE(marks.marks().front().on_level);
  EXPECT_EQ(marks.marks().front().level, 1);
}

TEST(ObjectMarks, WithoutDistanceItStaysPending) {
  Robot robot;
  ObjectMarks marks{{}};
  for (int i = 0; i < 10; ++i) {
    const Sighting sighting = robot.see(poseOnTheWay(0), kFace, "poison");
    marks.addPicture(robot.place(poseOnTheWay(0)), std::span(&sighting, 1));
  }
  ASSERT_EQ(marks.marks().size(), 1);
  EXPECT_EQ(marks.marks().front().state, MarkState::kPending);
}

TEST(ObjectMarks, TwoOfAClassSideBySideAreTwo) {
  Robot robot;
  ObjectMarks marks{{}};
  const Pose3 beside = faceAt({3.0, 0.25, 0.6});
  for (int i = 0; i < 30; ++i) {
    const Pose3 T = poseOnTheWay(i);
    const std::vector<Sighting> sightings = {robot.see(T, kFace, "poison", 0.002),
                                             robot.see(T, beside, "poison", 0.002)};
    marks.addPicture(robot.place(T), sightings);
  }
  ASSERT_EQ(marks.marks().size(), 2);
  EXPECT_EQ(marks.marks()[0].state, MarkState::kConfirmed);
  EXPECT_EQ(marks.marks()[1].state, MarkState::kConfirmed);
}

/// The box that a camera sees around a doll; only a part of it, seen from some sides.
Sighting seeDoll(const Pose3& T_world_camera, const Vector3d& p, double hidden) {
  constexpr double kHalfLength = 0.27;
  constexpr double kHeight = 0.16;
  double left = 1e9;
  double right = -1e9;
  double top = 1e9;
  double bottom = -1e9;
  for (const double along : {-kHalfLength, kHalfLength - hidden}) {
    for (const double across : {-0.08, 0.08}) {
      for (const double height : {0.0, kHeight}) {
        const Vector3d v = T_world_camera.inverse() * Vector3d(p + Vector3d(across, along, height));
        left = std::min(left, v.x() / v.z());
        right = std::max(right, v.x() / v.z());
        top = std::min(top, v.y() / v.z());
        bottom = std::max(bottom, v.y() / v.z());
      }
    }
  }
  Sighting sighting;
  sighting.label = {"victim", "victim", ""};
  sighting.score = 0.5;
  sighting.corners = {Vector3d(left, top, 1.0).normalized(), Vector3d(right, top, 1.0).normalized(),
                      Vector3d(right, bottom, 1.0).normalized(), Vector3d(left, bottom, 1.0).normalized()};
  return sighting;
}

TEST(ObjectMarks, ADollOfWhichMoreAndLessIsSeenIsOneMarkWhereItLies) {
  ObjectMarks marks{MarksConfig()};
  Robot robot;
  const Vector3d doll(2.0, 0.3, 0.0);
  for (int i = 0; i < 24; ++i) {
    const Pose3 camera = cameraAt({0.03 * i, -0.6 + 0.05 * i, 0.22}, 0.1);
    const std::vector<Sighting> seen = {seeDoll(camera, doll, i % 3 == 0 ? 0.2 : 0.0)};
    marks.addPicture(robot.place(camera), seen);
    if (i < 7) {
      ASSERT_EQ(marks.marks().front().state, MarkState::kPending) << i;
    }
  }
  ASSERT_EQ(marks.marks().size(), 1U);
  EXPECT_EQ(marks.marks().front().state, MarkState::kConfirmed);
  EXPECT_LT((marks.marks().front().position.p_world - doll).norm(), 0.15);
}

TEST(ObjectMarks, AnotherDollInTheSameDirectionIsNotTheSame) {
  const Vector3d first(2.4, -0.9, 0.0);
  const Vector3d second(1.4, -0.61, 0.0);
  ObjectMarks marks{MarksConfig()};
  Robot robot;
  for (int i = 0; i < 10; ++i) {
    const Pose3 camera = cameraAt({0.1 * i, -0.02 * i, 0.22}, -0.3);
    Sighting sighting = seeDoll(camera, first, 0.0);
    sighting.lidar = RangeMeasurement{(first - camera.translation()).norm() + 0.2, 0.3};
    marks.addPicture(robot.place(camera), std::vector{sighting});
  }
  const Vector3d before = marks.marks().front().position.p_world;
  const Pose3 camera = cameraAt({0.55, 1.2, 0.22}, -1.2);  // 0.28 rad between the two, a metre
  marks.addPicture(robot.place(camera), std::vector{seeDoll(camera, second, 0.0)});
  ASSERT_EQ(marks.marks().size(), 2U);
  EXPECT_EQ(marks.marks().front().position.p_world, before);
}

TEST(ObjectMarks, ABoxThatWouldBeLongerThanABodyShowsSomethingNearer) {
  ObjectMarks marks{MarksConfig()};
  Robot robot;
  const Vector3d far(9.0, 0.0, 0.0);
  for (int i = 0; i < 10; ++i) {
    const Pose3 camera = cameraAt({7.0, -0.5 + 0.1 * i, 0.22}, 0.0);
    marks.addPicture(robot.place(camera), std::vector{seeDoll(camera, far, 0.0)});
  }
  const Pose3 camera = cameraAt({0.0, 0.0, 0.22}, 0.0);
  marks.addPicture(robot.place(camera), std::vector{seeDoll(camera, {0.8, 0.0, 0.0}, 0.0)});
  ASSERT_EQ(marks.marks().size(), 2U);
  EXPECT_EQ(marks.marks().front().views, 10);
}

TEST(ObjectMarks, ADollSeenFromOnePlaceOnlyStaysPending) {
  ObjectMarks marks{MarksConfig()};
  Robot robot;
  const Pose3 camera = cameraAt({0.0, 0.0, 0.22}, 0.1);
  for (int i = 0; i < 40; ++i) {
    Sighting sighting = seeDoll(camera, {2.0, 0.3, 0.0}, i % 3 == 0 ? 0.2 : 0.0);
    sighting.lidar = RangeMeasurement{2.0, 0.05};
    marks.addPicture(robot.place(camera), std::vector{sighting});
  }
  ASSERT_EQ(marks.marks().size(), 1U);
  EXPECT_EQ(marks.marks().front().state, MarkState::kPending);
}

TEST(ObjectMarks, ALabelThatWasTakenForADollIsALabel) {
  for (const double apart : {0.1, 0.6}) {  // A label that hangs beside a doll changes nothing.
    ObjectMarks marks{MarksConfig()};
    Robot robot;
    const Vector3d doll(2.0, 0.3, 0.0);
    const Pose3 label = faceAt(doll + Vector3d(0.0, apart, 0.1));
    for (int i = 0; i < 24; ++i) {
      const Pose3 camera = cameraAt({0.03 * i, -0.6 + 0.05 * i, 0.22}, 0.1);
      std::vector<Sighting> seen = {seeDoll(camera, doll, 0.0)};
      if (i >= 12) {
        seen.push_back(robot.see(camera, label, "poison"));
      }
      marks.addPicture(robot.place(camera), seen);
    }
    ASSERT_EQ(marks.marks().size(), 2U);
    EXPECT_EQ(marks.marks()[0].state, apart > 0.5 ? MarkState::kConfirmed : MarkState::kPending) << apart;
    EXPECT_EQ(marks.marks()[1].state, MarkState::kConfirmed) << apart;
  }
}

TEST(ObjectMarks, AWrongClassAtItsPlaceIsNotConfirmed) {
  Robot robot;
  ObjectMarks marks{{}};
  for (int i = 0; i < 30; ++i) {
    const Pose3 T = poseOnTheWay(i);
    const Sighting sighting = robot.see(T, kFace, i % 4 == 3 ? "corrosive" : "poison");
    marks.addPicture(robot.place(T), std::span(&sighting, 1));
  }
  ASSERT_EQ(marks.marks().size(), 2);
  for (const Mark& mark : marks.marks()) {
    EXPECT_EQ(mark.state == MarkState::kConfirmed, mark.label.class_name == "poison");
  }
}

TEST(ObjectMarks, PendingOnesAreForgottenAndTheirNumberIsBounded) {
  Robot robot;
  ObjectMarks marks{{}};
  const Pose3 T = poseOnTheWay(0);
  for (int i = 0; i < 600; ++i) {
    const Sighting sighting = robot.see(T, kFace, "class " + std::to_string(i));
    marks.addPicture({1 + i, T, true, 0, -1}, std::span(&sighting, 1));
  }
  EXPECT_LE(marks.marks().size(), 300);
  marks.addPicture({60 * common::kMicrosecondsPerSecond, T, true, 0, -1}, {});
  EXPECT_TRUE(marks.marks().empty());
}

TEST(ObjectMarks, TheOperatorsWordHolds) {
  Robot robot;
  ObjectMarks marks{{}};
  const auto look = [&](int pictures) {
    for (int i = 0; i < pictures; ++i) {
      const Pose3 T = poseOnTheWay(i);
      const Sighting sighting = robot.see(T, kFace, "poison");
      marks.addPicture(robot.place(T), std::span(&sighting, 1));
    }
  };
  look(20);
  marks.discard(1);
  look(20);
  ASSERT_EQ(marks.marks().size(), 1) << "it does not come back under another name";
  EXPECT_EQ(marks.marks().front().state, MarkState::kDiscarded);
  marks.confirm(1);
  look(20);
  EXPECT_EQ(marks.marks().front().state, MarkState::kConfirmed);
  EXPECT_THROW(marks.discard(17), common::Error);
}

TEST(ObjectMarks, OffTheLevelTheyFollowTheirKeyframe) {
  Robot robot;
  for (const bool on_level : {false, true}) {
    ObjectMarks marks{{}};
    for (int i = 0; i < 20; ++i) {
      const Pose3 T = poseOnTheWay(i);
      const Sighting sighting = robot.see(T, kFace, "poison");
      marks.addPicture(robot.place(T, on_level), std::span(&sighting, 1));
    }
    const Vector3d before = marks.marks().front().position.p_world;
    Similarity keyframe;
    keyframe.p = poseOnTheWay(10).translation();
    marks.follow(false, [&](std::int32_t) { return std::optional(keyframe); });
    // A loop closes: turned about the keyframe, moved, and a twentieth larger.
    Similarity corrected = keyframe;
    corrected.R = Eigen::AngleAxisd(0.1, Vector3d::UnitZ()).toRotationMatrix();
    corrected.p += Vector3d(0.3, -0.2, 0.1);
    corrected.scale *= 1.05;
    marks.follow(true, [&](std::int32_t) { return std::optional(corrected); });
    const Vector3d after = marks.marks().front().position.p_world;
    const Vector3d expected =
        on_level ? before : Vector3d(corrected.p + 1.05 * (corrected.R * (before - keyframe.p)));
    EXPECT_LT((after - expected).norm(), 1e-9);
    marks.follow(false, [&](std::int32_t) { return std::optional(corrected); });
    EXPECT_EQ(marks.marks().front().position.p_world, after);
  }
}

}  // namespace
}  // namespace rubble::fusion
