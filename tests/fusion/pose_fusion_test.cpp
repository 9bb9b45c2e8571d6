#include "pose_fusion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "drive.h"

namespace rubble::fusion {
namespace {

using common::Pose3;
using common::Utime;

constexpr double kSpeed = 0.5;  // m/s
constexpr Utime kPicture = 100'000;
constexpr Utime kScan = 25'000;

FusionConfig inMode(const char* mode) {
  FusionConfig config;
  config.plane.mode = mode;
  return config;
}

/// A drive over level floor; the LiDAR sees it as it is, vision at a scale that the test decides.
class PoseFusionTest : public testing::TestWithParam<const char*> {
 protected:
  /// Drives on; returns the farthest that the pose was off, m. `scale`: of vision's steps.
  double drive(double metres, double scale) {
    double farthest = 0.0;
    for (const double end = way_ + metres; way_ < end;) {
      now_ += kScan;
      way_ += kSpeed * common::secondsFromUtime(kScan);
      height_ += kSpeed * common::secondsFromUtime(kScan) * std::sin(slope_);
      const Pose3 T_world_body = bodyNow();
      fusion_->addLidar({.utime = now_,
                         .T_world_lidar = T_level_world() * test::level(T_world_body * robot_.T_body_lidar()),
                         .covariance = 1e-4 * Eigen::Matrix3d::Identity(),
                         .good = lidar_matches_,
                         .revision = fusion_->plane().revision()});
      if (now_ % kPicture == 0) {
        farthest = std::max(farthest, picture(T_world_body, scale));
        if (ranges_) {
          fusion_->addScale(now_, std::log(scale));
        }
      }
    }
    return farthest;
  }
  /// Drives on while no scan comes, and one picture is missing; returns how far off the next one's pose is,
  /// m.
  double driveWithAPause() {
    double off = 0.0;
    for (int i = 0; i < 5; ++i) {
      now_ += kPicture;
      way_ += kSpeed * common::secondsFromUtime(kPicture);
      if (i == 3) {
        fusion_->advance(now_);
      } else {
        off = picture(test::windingPath(way_), 1.0);
      }
    }
    return off;
  }
  /// From the start again, with another fusion.
  void restart() {
    fusion_.emplace(inMode(GetParam()), robot_);
    way_ = 0.0;
    lidar_matches_ = true;
    T_world_camera_ = robot_.T_body_camera();
    newMap();
  }
  void newMap() {
    ++map_id_;
    T_mono_camera_ = Pose3::Identity();
  }

  /// Vision takes a turn upwards that was none.
  void tiltVision(double angle) { T_mono_camera_.rotate(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitX())); }

  /// The monocular map is corrected while the body pitches upwards.
  void correctMapInATurn(double angle) {
    Pose3 T_new_old = common::pose3FromPose2({0.4, -0.3, 0.2}, 0.1);
    T_new_old.rotate(Eigen::AngleAxisd(0.15, Eigen::Vector3d::UnitY()));
    T_mono_camera_ = T_new_old * T_mono_camera_;
    for (std::int32_t id = 0; id < next_keyframe_; ++id) {
      const auto located = keyframes_.locate({.utime = 0, .keyframe_id = id});
      keyframes_.set(id, {.map_id = map_id_, .T_parent_camera = T_new_old * located->T_mono_camera});
    }
    ++revision_;
    pitch_ += angle;
  }

  /// At the last picture, rad.
  double attitudeError() const {
    const Pose3 T_world_body = T_world_camera_ * robot_.T_body_camera().inverse();
    return Eigen::AngleAxisd(T_world_body.linear().transpose() * state_.T_world_body.linear()).angle();
  }

  Pose3 bodyNow() const {
    Pose3 T = test::windingPath(way_);
    T.translation().z() = height_;
    return test::pitchedUp(T, pitch_ + slope_);
  }

  /// A level's grid begins where the pose is then.
  common::Pose2 T_level_world() {
    if (const int level = fusion_->plane().levelId(); level >= static_cast<int>(T_levels_world_.size())) {
      const Pose3 T_body_lidar = robot_.T_body_lidar();
      T_levels_world_.push_back(test::level(state_.T_world_body * T_body_lidar) *
                                test::level(last_body_ * T_body_lidar).inverse());
    }
    return T_levels_world_[static_cast<std::size_t>(fusion_->plane().levelId())];
  }

  /// Deviation of the position in the plane, m.
  double sigma() const { return std::sqrt(state_.covariance.topLeftCorner<2, 2>().trace()); }

  /// Vision turns aside a little more with every picture.
  double turn_aside_ = 0.0;
  double slope_ = 0.0;  // That the robot drives up.

  /// Vision goes sideways where the robot does not.
  void shiftVision(double metres) { T_mono_camera_.translate(Eigen::Vector3d(metres, 0.0, 0.0)); }

  bool lidar_matches_ = true;
  bool ranges_ = false;  // At map points; of the true scale.
  RobotState state_;     // At the last picture.
  Utime now_ = 1'700'000'000'000'000;
  const common::RobotConfig robot_ = test::robot();
  std::optional<PoseFusion> fusion_{std::in_place, inMode(GetParam()), robot_};

 private:
  double picture(const Pose3& T_world_body, double scale) {
    const Pose3 T_world_camera = T_world_body * robot_.T_body_camera();
    Pose3 step = T_world_camera_.inverse() * T_world_camera;
    step.translation() /= scale;
    step.rotate(Eigen::AngleAxisd(turn_aside_, Eigen::Vector3d::UnitY()));
    T_mono_camera_ = T_mono_camera_ * step;
    T_world_camera_ = T_world_camera;
    last_body_ = T_world_body;
    state_ = fusion_->addMono({now_, true, map_id_, revision_, T_mono_camera_});
    // One keyframe for each picture.
    keyframes_.set(next_keyframe_, {.map_id = map_id_, .T_parent_camera = T_mono_camera_});
    pictures_.push_back({.utime = now_, .keyframe_id = next_keyframe_++});
    if (pictures_.size() == 5) {
      fusion_->addPictures(pictures_, keyframes_, revision_);
      pictures_.clear();
    }
    return (state_.T_world_body.translation() - T_world_body.translation()).norm();
  }

  double way_ = 0.0;
  double height_ = 0.0;
  double pitch_ = 0.0;                   // Of the body, upwards.
  Pose3 last_body_ = Pose3::Identity();  // At the last picture.
  std::vector<common::Pose2> T_levels_world_{1};
  std::int32_t map_id_ = 1;
  std::int64_t revision_ = 0;
  Pose3 T_world_camera_ = robot_.T_body_camera();
  Pose3 T_mono_camera_ = Pose3::Identity();
  common::KeyframePoses keyframes_;
  std::int32_t next_keyframe_ = 0;
  std::vector<common::AnchoredPose> pictures_;
};

TEST_P(PoseFusionTest, AYoungScaleIsNotHeldAgainstTheLidar) {
  EXPECT_LT(drive(5.0, 1.0), 0.03);
  newMap();
  // As in a map that was begun in a turn.
  EXPECT_LT(drive(1.0, 1.0), 0.05);
  EXPECT_LT(drive(4.0, 2.5), 0.05);
  EXPECT_EQ(fusion_->plane().contradicted(), 0);
}

TEST_P(PoseFusionTest, AScaleThatRanAwayOnLevelGroundIsLearntAnewAtOnce) {
  EXPECT_LT(drive(8.0, 1.0), 0.03);
  EXPECT_LT(drive(1.0, 2.5), 0.35);
  EXPECT_EQ(fusion_->plane().contradicted(), 1);
  EXPECT_LT(drive(8.0, 2.5), 0.05);
  EXPECT_EQ(fusion_->plane().contradicted(), 1);
  EXPECT_EQ(fusion_->plane().state(), ControlState::kH);
}

TEST_P(PoseFusionTest, AfterALidarThatInsistedVisionIsNotBelievedAgain) {
  drive(8.0, 1.0);
  tiltVision(0.07);
  drive(1.2, 2.5);
  ASSERT_EQ(fusion_->plane().state(), ControlState::kR) << "a tilt that may be an error";
  drive(1.7, 2.5);
  ASSERT_EQ(fusion_->plane().state(), ControlState::kH) << "the LiDAR has contradicted for three seconds";
  EXPECT_LT(drive(6.0, 2.5), 0.05);
  EXPECT_EQ(fusion_->plane().contradicted(), 0);
  EXPECT_EQ(fusion_->plane().state(), ControlState::kH);
}

TEST_P(PoseFusionTest, ARestoredPoseGoesToWhereTheLidarIs) {
  EXPECT_LT(drive(8.0, 1.0), 0.03);
  FusionMemory memory = fusion_->memory();
  memory.last.T_world_camera.translation().x() += 0.2;
  fusion_.emplace(inMode(GetParam()), robot_);
  fusion_->restore(memory);
  drive(0.5, 1.0);
  EXPECT_LT(drive(4.0, 1.0), 0.03);
}

TEST_P(PoseFusionTest, APictureThatIsMissingIsNoLossOfVision) {
  drive(8.0, 1.0);
  shiftVision(0.06);
  drive(2.0, 1.0);
  ASSERT_LT(drive(0.1, 1.0), 0.015) << "where the LiDAR is";
  EXPECT_LT(driveWithAPause(), 0.02) << "not where the alignment of ten metres has it";
}

TEST_P(PoseFusionTest, OutOfRThePoseGoesToTheLidarAtOnce) {
  drive(8.0, 1.0);
  tiltVision(0.07);
  drive(0.45, 1.3);
  ASSERT_EQ(fusion_->plane().state(), ControlState::kM);
  tiltVision(-0.07);
  drive(0.4, 1.0);
  ASSERT_EQ(fusion_->plane().state(), ControlState::kH);
  drive(0.2, 1.0);
  EXPECT_LT(drive(1.0, 1.0), 0.03);
  EXPECT_EQ(fusion_->plane().contradicted(), 0);
}

TEST_P(PoseFusionTest, ATurnWhileTheMapWasCorrectedIsNoErrorForGood) {
  drive(8.0, 1.0);
  const double before = attitudeError();
  correctMapInATurn(0.1);
  drive(0.05, 1.0);
  EXPECT_GT(attitudeError(), 0.05) << "nobody can know at once";
  drive(0.4, 1.0);
  EXPECT_LT(attitudeError(), before + 0.01);
}

TEST_P(PoseFusionTest, ATiltThatVisionInventsOnLevelGroundIsForgotten) {
  drive(8.0, 1.0);
  tiltVision(0.08);
  drive(0.5, 1.0);
  EXPECT_GT(attitudeError(), 0.06);
  EXPECT_NE(fusion_->plane().state(), ControlState::kH);
  EXPECT_LT(drive(4.0, 1.0), 0.2);
  EXPECT_LT(attitudeError(), 0.02);
  EXPECT_EQ(fusion_->plane().state(), ControlState::kH);
}

TEST_P(PoseFusionTest, VisionThatTurnsOtherwiseThanTheLidarIsLeftAlone) {
  drive(8.0, 1.0);
  turn_aside_ = 0.02;  // 11 degrees a second.
  EXPECT_LT(drive(1.0, 1.0), 0.1);
  EXPECT_TRUE(fusion_->visionAstray());
  turn_aside_ = 0.0;
  EXPECT_LT(drive(6.0, 0.2), 0.1) << "as if in another map";
  EXPECT_FALSE(fusion_->visionAstray());
  EXPECT_EQ(fusion_->plane().state(), ControlState::kH);
  EXPECT_TRUE(fusion_->visionTracks());
  EXPECT_NEAR(*fusion_->scaleOf(1), 0.2, 0.02);
}

TEST_P(PoseFusionTest, ALevelIsAsUnsureAsThePoseWasThatBeganIt) {
  drive(8.0, 1.0);
  const double below = sigma();
  slope_ = 0.4;
  const double drift = drive(2.0, 1.06);
  slope_ = 0.0;
  for (int i = 0; i < 40 && fusion_->plane().levelId() == 0; ++i) {
    drive(0.05, 1.0);
  }
  ASSERT_EQ(fusion_->plane().levelId(), 1);
  ASSERT_EQ(fusion_->plane().state(), ControlState::kH);
  EXPECT_NEAR(fusion_->plane().level().floor, state_.T_world_body.translation().z(), 0.02);
  const double begins = std::sqrt(fusion_->plane().level().covariance.topLeftCorner<2, 2>().trace());
  const double error = drive(0.1, 1.0);
  EXPECT_GT(drift, 0.06);
  EXPECT_GT(begins, below + 0.02);
  EXPECT_LT(error, 3.0 * begins);
  for (int i = 0; i < 8; ++i) {
    EXPECT_NEAR(drive(0.5, 1.0), error, 0.03) << "the level lies where it began";
    EXPECT_GE(sigma(), begins) << "scans tell where the robot is on the level, not where the level is";
  }
  EXPECT_EQ(fusion_->plane().state(), ControlState::kH);
  slope_ = -0.4;
  drive(2.0, 1.0);
  slope_ = 0.0;
  EXPECT_LT(drive(3.0, 1.0), 0.5);
  ASSERT_EQ(fusion_->plane().state(), ControlState::kH);
  ASSERT_EQ(fusion_->plane().levelId(), 0);
  EXPECT_LT(drive(0.5, 1.0), 0.03);
  EXPECT_LT(sigma(), below + 0.01);
}

using JointFusionTest = PoseFusionTest;

TEST_P(JointFusionTest, RangesAtMapPointsHoldTheScaleWithoutMatches) {
  drive(8.0, 1.0);
  lidar_matches_ = false;
  const double without = drive(3.0, 1.02);
  restart();
  drive(8.0, 1.0);
  lidar_matches_ = false;
  ranges_ = true;
  EXPECT_LT(drive(3.0, 1.02), 0.7 * without);
}

TEST_P(JointFusionTest, ANewMapIsAnchoredByRangesAtOnce) {
  drive(8.0, 1.0);
  lidar_matches_ = false;
  newMap();
  EXPECT_GT(drive(3.0, 1.4), 2.5) << "nobody knows its scale";
  newMap();
  ranges_ = true;
  drive(0.3, 0.7);
  const double before = drive(0.1, 0.7);
  EXPECT_NEAR(drive(3.0, 0.7), before, 0.05) << "the pose goes on from where it was";
}

TEST_P(JointFusionTest, AfterBlindnessTheWindowBeginsAsUnsureAsThePoseIs) {
  drive(8.0, 1.0);
  const double sure = state_.covariance(0, 0);
  for (int i = 0; i < 20; ++i) {
    now_ += kPicture;
    fusion_->advance(now_);
  }
  lidar_matches_ = false;
  newMap();
  ranges_ = true;
  drive(1.0, 1.4);
  EXPECT_GT(state_.covariance(0, 0), sure + 0.04) << "two seconds at up to half a metre each";
}

INSTANTIATE_TEST_SUITE_P(Modes, JointFusionTest, testing::Values("joint"));

INSTANTIATE_TEST_SUITE_P(Modes, PoseFusionTest, testing::Values("lsm-robust", "joint"), [](const auto& mode) {
  return std::string(mode.param) == "joint" ? "Joint" : "LsmRobust";
});

}  // namespace
}  // namespace rubble::fusion
