#include "fusion/fusion_node.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <rubble/command_t.hpp>
#include <rubble/detections_t.hpp>
#include <rubble/fusion_state_t.hpp>
#include <rubble/lidar_control_t.hpp>
#include <rubble/lidar_pose_t.hpp>
#include <rubble/mono_features_t.hpp>
#include <rubble/mono_map_t.hpp>
#include <rubble/mono_pose_t.hpp>
#include <rubble/objects_t.hpp>
#include <rubble/robot_pose_t.hpp>
#include <rubble/stabilizer_command_t.hpp>
#include <rubble/stabilizer_t.hpp>
#include <vector>

#include "drive.h"
#include "lcm_io/channels.h"
#include "lcm_io/conversions.h"
#include "lcm_io/replay_hub.h"
#include "support/temp_dir.h"

namespace rubble::fusion {
namespace {

using common::Pose3;
using common::Utime;
using Eigen::Vector3d;

constexpr Utime kStart = 1'700'000'000'000'000;
constexpr double kSpeed = 0.5;  // m/s
/// Metres of way: level floor, a steep ramp up, a platform, the ramp down, and on.
constexpr double kRampFrom = 6.0, kRampTo = 8.0, kDownFrom = 9.0, kDownTo = 11.0;
constexpr double kSlope = 0.5;  // rad

/// Winds over the floor, then straight over the ramp.
Pose3 bodyAfter(double way) {
  const double along = std::min(way, kRampFrom);
  Pose3 T = test::windingPath(along);
  const auto climb = [&](double from, double to, double slope) {
    const double s = std::clamp(way, from, to) - from;
    T.translate(Vector3d(s * std::cos(slope), 0.0, s * std::sin(slope)));
  };
  climb(kRampFrom, kRampTo, kSlope);
  climb(kRampTo, kDownFrom, 0.0);
  climb(kDownFrom, kDownTo, -kSlope);
  climb(kDownTo, 1e9, 0.0);
  const bool up = way > kRampFrom && way < kRampTo;
  const bool down = way > kDownFrom && way < kDownTo;
  return test::pitchedUp(T, up ? kSlope : down ? -kSlope : 0.0);
}

/// The node on a hub; vision and LiDAR that see a drive as it is, the LiDAR as LIDAR_CONTROL allows.
class FusionNodeTest : public testing::Test {
 protected:
  FusionNodeTest() { makeNode({}); }

  void makeNode(const std::filesystem::path& state_dir) {
    node_.reset();
    hub_ = std::make_unique<lcm_io::ReplayHub>();
    hub_->advanceTo(now_);
    bus_ = &hub_->endpoint();
    common::Config config;
    config.addOverride("robot.plate.translation=[0.10,0.0,0.25]");
    config.addOverride("robot.camera.translation=[0.12,0.03,0.22]");
    node_ = makeFusion(config, state_dir);
    lcm_io::Bus& ears = hub_->endpoint();
    ears.subscribe<rubble::robot_pose_t>(lcm_io::channel::kRobotPose,
                                         [this](const auto& m) { poses_.push_back(m); });
    ears.subscribe<rubble::lidar_control_t>(lcm_io::channel::kLidarControl,
                                            [this](const auto& m) { control_ = m; });
    ears.subscribe<rubble::fusion_state_t>(lcm_io::channel::kFusionState,
                                           [this](const auto& m) { state_ = m; });
    ears.subscribe<rubble::stabilizer_command_t>(lcm_io::channel::kStabilizerCommand, [this](const auto& m) {
      ++commands_;
      command_ = m;
    });
  }
  std::unique_ptr<lcm_io::Node> makeFusion(const common::Config& config, const std::filesystem::path& dir) {
    return fusion::makeNode({.bus = *bus_, .config = config, .state_dir = dir});
  }

  template <typename Message>
  void feed(const char* channel, const Message& message) {
    hub_->advanceTo(now_);
    node_->advance(now_);
    hub_->feed({channel, now_, lcm_io::encode(message)});
    node_->advance(now_);
    hub_->deliverPending();
  }

  /// Drives on for some metres.
  void drive(double metres) {
    for (const double end = way_ + metres; way_ < end;) {
      step(kSpeed);
    }
  }
  void stand(double seconds) {
    for (const Utime end = now_ + common::utimeFromSeconds(seconds); now_ < end;) {
      step(0.0);
    }
  }

  /// A 120th of a second: sensors at 30, 40 and 60 Hz.
  void step(double speed) {
    now_ += 8'333;
    way_ += speed * 8'333e-6;
    T_world_body_ = bodyAfter(way_);
    ++ticks_;
    if (ticks_ % 2 == 0) {
      feed(lcm_io::channel::kStabilizer, stabilizer());
    }
    if (ticks_ % 4 == 0 && camera_on_) {
      feed(lcm_io::channel::kMonoPose, monoPose());
      mapFrame();
    }
    if (ticks_ % 3 == 0 && lidar_on_) {
      feed(lcm_io::channel::kLidarPose, lidarPose());
    }
    if (ticks_ % 60 == 0 && camera_on_) {
      feed(lcm_io::channel::kMonoMap, map_);
      map_.frames.clear();
      map_.nframes = 0;
    }
  }

  rubble::stabilizer_t stabilizer() const {
    rubble::stabilizer_t m{};
    m.utime = now_;
    return m;
  }

  Pose3 monoCamera() const {
    return test::T_mono_camera(T_world_body_ * robot_.T_body_camera(), test::S_world_mono());
  }

  rubble::mono_pose_t monoPose() const {
    if (other_map_) {
      rubble::mono_pose_t m{};
      m.utime = now_;
      m.state = rubble::mono_pose_t::STATE_TRACKING;
      m.map_id = 2;
      lcm_io::poseToMessage(*other_map_ * T_world_body_ * robot_.T_body_camera(), m.p_mono_camera,
                            m.q_mono_camera);
      return m;
    }
    rubble::mono_pose_t m{};
    m.utime = now_;
    m.state =
        way_ < vision_starts_ ? rubble::mono_pose_t::STATE_INITIALIZING : rubble::mono_pose_t::STATE_TRACKING;
    m.map_id = 1;
    lcm_io::poseToMessage(monoCamera(), m.p_mono_camera, m.q_mono_camera);
    return m;
  }

  /// All hang on one keyframe.
  void mapFrame() {
    if (way_ < 0.2) {
      return;
    }
    if (map_.keyframes.empty()) {
      rubble::mono_keyframe_t keyframe{};
      keyframe.id = 0;
      keyframe.map_id = 1;
      keyframe.scale = 1.0;
      keyframe.parent = -1;
      lcm_io::poseToMessage(monoCamera(), keyframe.p_mono_camera, keyframe.q_mono_camera);
      T_mono_keyframe_ = monoCamera();
      map_.keyframes = {keyframe};
      map_.nkeyframes = 1;
    }
    rubble::mono_frame_t frame{};
    frame.utime = now_;
    frame.keyframe_id = 0;
    frame.keyframe_scale = 1.0;
    lcm_io::poseToMessage(T_mono_keyframe_.inverse() * monoCamera(), frame.p_keyframe_camera,
                          frame.q_keyframe_camera);
    map_.frames.push_back(frame);
    map_.nframes = static_cast<std::int32_t>(map_.frames.size());
  }

  rubble::lidar_pose_t lidarPose() const {
    const common::Pose2 T = test::level(T_world_body_ * robot_.T_body_lidar());
    const bool suspended = control_ && control_->state == rubble::lidar_control_t::STATE_M;
    rubble::lidar_pose_t m{};
    m.utime = now_;
    m.x = T.x;
    m.y = T.y;
    m.yaw = T.yaw;
    m.covariance[0] = m.covariance[4] = m.covariance[8] = 1e-4;
    m.score = 1.0;
    m.status = suspended ? rubble::lidar_pose_t::STATUS_UNMATCHED : rubble::lidar_pose_t::STATUS_GOOD;
    m.control_revision = control_ ? control_->revision : -1;
    return m;
  }

  double positionError() const {
    const Pose3 T = lcm_io::poseFromMessage(poses_.back().p_world_body, poses_.back().q_world_body);
    return (T.translation() - bodyThen().translation()).norm();
  }
  double attitudeError() const {
    const Pose3 T = lcm_io::poseFromMessage(poses_.back().p_world_body, poses_.back().q_world_body);
    return test::angleBetween(T.linear(), bodyThen().linear());
  }
  /// Where the body was at the last pose's time.
  Pose3 bodyThen() const {
    return bodyAfter(way_ - kSpeed * common::secondsFromUtime(now_ - poses_.back().utime));
  }
  int state() const { return control_->state; }

  const common::RobotConfig robot_ = test::robot();
  std::unique_ptr<lcm_io::ReplayHub> hub_;
  lcm_io::Bus* bus_ = nullptr;
  std::unique_ptr<lcm_io::Node> node_;
  Utime now_ = kStart;
  double way_ = 0.0;
  Pose3 T_world_body_ = Pose3::Identity();
  int ticks_ = 0;
  bool camera_on_ = true;
  bool lidar_on_ = true;
  double vision_starts_ = 0.2;      // m of driving, until which it initialises
  std::optional<Pose3> other_map_;  // Vision is in a map of its own.
  rubble::mono_map_t map_{};
  Pose3 T_mono_keyframe_ = Pose3::Identity();

  std::vector<rubble::robot_pose_t> poses_;
  std::optional<rubble::lidar_control_t> control_;
  std::optional<rubble::fusion_state_t> state_;
  rubble::stabilizer_command_t command_{};
  int commands_ = 0;
};

TEST_F(FusionNodeTest, IsPassiveUntilVisionSpeaks) {
  camera_on_ = false;
  drive(0.5);
  EXPECT_TRUE(poses_.empty());
  EXPECT_FALSE(control_);
  EXPECT_NE(node_->status().detail.find("no MONO_POSE yet"), std::string::npos);
}

TEST_F(FusionNodeTest, LearnsTheScaleOnTheFloor) {
  drive(5.0);
  ASSERT_TRUE(state_ && state_->scale_known);
  EXPECT_NEAR(state_->scale / test::S_world_mono().scale, 1.0, 0.005);
  EXPECT_LT(positionError(), 0.03);
  EXPECT_LT(attitudeError(), 0.01);
  EXPECT_EQ(state(), rubble::lidar_control_t::STATE_H);
  EXPECT_NEAR(Vector3d(poses_.back().v_world_body).norm(), kSpeed, 0.05);
  EXPECT_TRUE(node_->status().detail.empty()) << node_->status().detail;
  // One pose for every picture, control at least at 10 Hz, set-points at 50 Hz.
  EXPECT_EQ(poses_.size(), static_cast<std::size_t>(ticks_ / 4));
  EXPECT_GT(commands_, ticks_ * 85 / 120) << "100 Hz, on ticks of 120 Hz";
  EXPECT_LE(commands_, ticks_ * 100 / 120 + 1);
}

TEST_F(FusionNodeTest, VisionMayStartWithinAMetre) {
  vision_starts_ = 100.0;
  drive(0.8);
  EXPECT_TRUE(node_->status().detail.empty()) << node_->status().detail;
  drive(0.5);
  EXPECT_NE(node_->status().detail.find("vision has not started"), std::string::npos)
      << node_->status().detail;
}

TEST_F(FusionNodeTest, CarriesThePoseOverTheRamp) {
  drive(7.0);
  EXPECT_EQ(state(), rubble::lidar_control_t::STATE_M);
  EXPECT_LT(control_->confirmed_h_utime, now_ - common::utimeFromSeconds(1.0 / kSpeed - 0.4))
      << "no scan on the ramp may be written";
  EXPECT_NEAR(command_.pitch, 0.35, 1e-6) << "at the end of the servos' range";
  drive(1.3);
  EXPECT_EQ(state(), rubble::lidar_control_t::STATE_M) << "level, but a metre too high";
  EXPECT_LT(positionError(), 0.05);
  drive(3.7);
  EXPECT_EQ(state(), rubble::lidar_control_t::STATE_H);
  EXPECT_LT(positionError(), 0.05);
  EXPECT_LT(attitudeError(), 0.02);
}

TEST_F(FusionNodeTest, ThePlatformIsALevelOfItsOwnWhichSurvives) {
  const rubble::test::TempDir dir;
  makeNode(dir.path());
  drive(8.3);
  ASSERT_EQ(state(), rubble::lidar_control_t::STATE_M);
  const double drifted = poses_.back().covariance[0];
  stand(1.5);
  EXPECT_EQ(state(), rubble::lidar_control_t::STATE_H);
  EXPECT_EQ(control_->level, 1);
  EXPECT_EQ(poses_.back().level, 1);
  drive(0.3);
  EXPECT_LT(positionError(), 0.05);
  EXPECT_LT(attitudeError(), 0.02);
  EXPECT_GT(poses_.back().covariance[0], 0.9 * drifted) << "its place in world is known no better";
  EXPECT_GT(control_->confirmed_h_utime, now_ - common::utimeFromSeconds(0.4));

  node_->finish();
  makeNode(dir.path());
  drive(0.2);
  EXPECT_EQ(control_->level, 1);
  EXPECT_LT(positionError(), 0.05);
  drive(4.5);
  EXPECT_EQ(state(), rubble::lidar_control_t::STATE_H);
  EXPECT_EQ(control_->level, 0);
  EXPECT_LT(positionError(), 0.05);
  EXPECT_LT(poses_.back().covariance[0], drifted);
}

TEST_F(FusionNodeTest, LidarOffAndCameraOffOnTheFloor) {
  drive(3.0);
  lidar_on_ = false;
  drive(1.0);
  EXPECT_LT(positionError(), 0.03);
  EXPECT_NE(node_->status().detail.find("vision alone carries"), std::string::npos) << node_->status().detail;
  lidar_on_ = true;
  camera_on_ = false;
  drive(1.0);
  EXPECT_LT(positionError(), 0.08);
  EXPECT_LT(attitudeError(), 0.02);
  EXPECT_NE(node_->status().detail.find("MONO_POSE is silent"), std::string::npos) << node_->status().detail;
  lidar_on_ = false;
  stand(0.5);
  const double sigma = std::sqrt(poses_.back().covariance[0]);
  stand(2.0);
  EXPECT_GT(std::sqrt(poses_.back().covariance[0]), sigma + 0.2) << "nothing sees motion";
  camera_on_ = lidar_on_ = true;
  drive(0.5);
  EXPECT_LT(positionError(), 0.05);
  EXPECT_TRUE(node_->status().detail.empty()) << node_->status().detail;
}

TEST_F(FusionNodeTest, CameraOffOnTheRampIsSaidAndNothingIsWritten) {
  drive(7.0);
  camera_on_ = false;
  stand(1.0);
  EXPECT_EQ(poses_.back().attitude, rubble::robot_pose_t::ATTITUDE_UNKNOWN);
  EXPECT_NE(state(), rubble::lidar_control_t::STATE_H);
  EXPECT_EQ(node_->status().level, lcm_io::NodeStatus::Level::kDegraded);
  EXPECT_NE(node_->status().detail.find("attitude is unknown"), std::string::npos);
  camera_on_ = true;
  stand(0.5);
  EXPECT_EQ(poses_.back().attitude, rubble::robot_pose_t::ATTITUDE_KNOWN);
  EXPECT_LT(positionError(), 0.06);
}

TEST_F(FusionNodeTest, ACorrectionOfTheMapDoesNotMoveTheRobot) {
  drive(4.0);
  // A loop was closed: the map is another 10 % smaller and turned.
  const double error = positionError();
  Similarity correction;
  correction.scale = 0.9;
  correction.R = common::rotationFromRpy({0.02, 0.05, 0.1});
  correction.p = {0.2, -0.1, 0.3};
  rubble::mono_keyframe_t& keyframe = map_.keyframes[0];
  lcm_io::poseToMessage(correction * T_mono_keyframe_, keyframe.p_mono_camera, keyframe.q_mono_camera);
  keyframe.scale = 0.9;
  map_.revision = 1;
  feed(lcm_io::channel::kMonoMap, map_);
  for (int i = 0; i < 10; ++i) {
    now_ += 33'333;
    rubble::mono_pose_t m = monoPose();
    m.map_revision = 1;
    lcm_io::poseToMessage(correction * monoCamera(), m.p_mono_camera, m.q_mono_camera);
    feed(lcm_io::channel::kMonoPose, m);
    const Pose3 T = lcm_io::poseFromMessage(poses_.back().p_world_body, poses_.back().q_world_body);
    EXPECT_LT((T.translation() - T_world_body_.translation()).norm(), error + 0.03);
  }
  feed(lcm_io::channel::kMonoMap, map_);
  now_ += 600'000;
  rubble::mono_pose_t m = monoPose();
  m.map_revision = 1;
  lcm_io::poseToMessage(correction * monoCamera(), m.p_mono_camera, m.q_mono_camera);
  feed(lcm_io::channel::kMonoPose, m);
  ASSERT_TRUE(state_);
  EXPECT_EQ(state_->map_revision, 1);
  EXPECT_NEAR(state_->scale * 0.9 / test::S_world_mono().scale, 1.0, 0.01) << "re-expressed";
}

TEST_F(FusionNodeTest, VisionThatReturnsFromAnotherMapIsTakenAtItsOldAlignment) {
  drive(4.0);
  camera_on_ = false;
  drive(0.3);
  camera_on_ = true;
  other_map_ = test::pitchedUp(Pose3::Identity(), 1.0);
  drive(0.5);
  EXPECT_LT(positionError(), 0.08) << "the LiDAR carries the pose while the new map has no scale";
  EXPECT_LT(attitudeError(), 0.05) << "a new map inherits the attitude";
  other_map_.reset();
  drive(0.3);
  EXPECT_EQ(state_->map_id, 1);
  EXPECT_LT(positionError(), 0.05);
  EXPECT_LT(attitudeError(), 0.02);
}

TEST_F(FusionNodeTest, AKilledProcessKeepsWorldScaleAndState) {
  const rubble::test::TempDir dir;
  makeNode(dir.path());
  drive(7.5);
  ASSERT_EQ(state(), rubble::lidar_control_t::STATE_M);
  const auto revision = control_->revision;
  node_->finish();
  makeNode(dir.path());
  drive(0.3);
  EXPECT_EQ(state(), rubble::lidar_control_t::STATE_M);
  EXPECT_GT(control_->revision, revision);
  EXPECT_LT(positionError(), 0.05) << "in M the scale is restored, never guessed";
  drive(4.5);
  EXPECT_EQ(state(), rubble::lidar_control_t::STATE_H);
  EXPECT_LT(positionError(), 0.05);
}

TEST_F(FusionNodeTest, SightingsBecomeMarksThatTheOperatorRulesAndThatSurvive) {
  const rubble::test::TempDir dir;
  makeNode(dir.path());
  std::optional<rubble::objects_t> objects;
  const auto listen = [&] {
    hub_->endpoint().subscribe<rubble::objects_t>(lcm_io::channel::kObjects,
                                                  [&](const auto& m) { objects = m; });
  };
  listen();
  const Vector3d p_world_object = bodyAfter(2.0) * Vector3d(2.0, 0.3, 0.5);
  const auto look = [&] {
    for (int i = 0; i < 8; ++i) {
      drive(0.1);
      rubble::detections_t message{};
      message.utime = poses_.back().utime;
      const Vector3d p = (bodyThen() * robot_.T_body_camera()).inverse() * p_world_object;
      rubble::detection_t detection;
      detection.class_name = std::string("poison");
      detection.kind = std::string("hazard");
      detection.score = 0.5F;
      detection.width = detection.height = 0.2;
      const double half = 0.1 * robot_.intrinsics.focal[0] / p.z();
      for (int k = 0; k < 4; ++k) {
        const double x = robot_.intrinsics.centre[0] + robot_.intrinsics.focal[0] * p.x() / p.z();
        const double y = robot_.intrinsics.centre[1] + robot_.intrinsics.focal[1] * p.y() / p.z();
        detection.quad_x[k] = static_cast<float>(x + (k == 1 || k == 2 ? half : -half));
        detection.quad_y[k] = static_cast<float>(y + (k >= 2 ? half : -half));
      }
      message.detections = {detection};
      message.n = 1;
      feed(lcm_io::channel::kDetections, message);
    }
    drive(0.6);
  };
  look();
  ASSERT_TRUE(objects);
  ASSERT_EQ(objects->n, 1);
  EXPECT_EQ(objects->objects.front().state, rubble::object_t::STATE_CONFIRMED);
  const Eigen::Map<const Vector3d> p(objects->objects.front().p_world_object);
  EXPECT_LT((p - p_world_object).norm(), 0.1);

  rubble::command_t command;
  command.target = std::string("fusion");
  command.verb = std::string("discard");
  command.argument = std::string("77");
  feed(lcm_io::channel::kCommand, command);
  EXPECT_EQ(bus_->received().at(lcm_io::channel::kCommand).errors, 1) << "no such mark";
  command.argument = std::to_string(objects->objects.front().id);
  feed(lcm_io::channel::kCommand, command);
  node_->finish();
  makeNode(dir.path());
  listen();
  look();
  ASSERT_EQ(objects->n, 1);
  EXPECT_EQ(objects->objects.front().state, rubble::object_t::STATE_DISCARDED);
  EXPECT_TRUE(objects->objects.front().by_operator);

  rubble::detections_t bad{};
  bad.utime = poses_.back().utime;
  bad.detections = {rubble::detection_t{}};
  bad.detections.front().quad_x[0] = std::numeric_limits<float>::quiet_NaN();
  bad.n = 1;
  feed(lcm_io::channel::kDetections, bad);
  EXPECT_EQ(bus_->received().at(lcm_io::channel::kDetections).errors, 1);
}

TEST_F(FusionNodeTest, BadMessagesAreRefusedAndItLives) {
  drive(1.0);
  rubble::mono_pose_t mono = monoPose();
  mono.utime = now_ + 1;
  mono.q_mono_camera[0] = std::numeric_limits<double>::quiet_NaN();
  feed(lcm_io::channel::kMonoPose, mono);
  mono = monoPose();
  mono.utime = kStart;
  feed(lcm_io::channel::kMonoPose, mono);
  EXPECT_EQ(bus_->received().at(lcm_io::channel::kMonoPose).errors, 2);
  rubble::lidar_pose_t lidar = lidarPose();
  lidar.x = std::numeric_limits<double>::infinity();
  feed(lcm_io::channel::kLidarPose, lidar);
  EXPECT_EQ(bus_->received().at(lcm_io::channel::kLidarPose).errors, 1);
  rubble::stabilizer_t stabilizer = this->stabilizer();
  stabilizer.roll = std::numeric_limits<double>::quiet_NaN();
  feed(lcm_io::channel::kStabilizer, stabilizer);
  EXPECT_EQ(bus_->received().at(lcm_io::channel::kStabilizer).errors, 1);
  rubble::mono_features_t features{};
  features.n = 1;  // Without octave and descriptor.
  features.x = features.y = features.angle = {1.0F};
  feed(lcm_io::channel::kMonoFeatures, features);
  EXPECT_EQ(bus_->received().at(lcm_io::channel::kMonoFeatures).errors, 1);
  drive(1.0);
  EXPECT_LT(positionError(), 0.05);
}

}  // namespace
}  // namespace rubble::fusion
