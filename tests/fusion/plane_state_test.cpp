#include "plane_state.h"

#include <gtest/gtest.h>

#include "common/geometry.h"
#include "common/robot_config.h"
#include "levelling.h"

namespace rubble::fusion {
namespace {

using common::Utime;
using Scan = PlaneState::Scan;

constexpr Utime kPicture = 33'333;

/// A state machine that is shown planes at picture rate.
class PlaneStateTest : public testing::Test {
 protected:
  void show(double seconds, double height, double tilt, bool attitude_known = true, double body_tilt = 0.0) {
    for (const Utime end = now_ + common::utimeFromSeconds(seconds); now_ < end; now_ += kPicture) {
      state_.addPlane(now_, {height, tilt, body_tilt}, attitude_known);
    }
  }
  void scans(int n, Scan scan) {
    for (int i = 0; i < n; ++i) {
      state_.addScan(scan);
    }
  }

  PlaneStateConfig config_;
  PlaneState state_{config_};
  Utime now_ = 1'000'000'000;
};

TEST_F(PlaneStateTest, ConfirmsWhileThePlaneIsUsable) {
  show(1.0, 0.0, 0.01);
  EXPECT_EQ(state_.state(), ControlState::kH);
  EXPECT_GT(state_.confirmed(), now_ - 300'000);
  EXPECT_LT(state_.confirmed(), now_ - 100'000);
}

TEST_F(PlaneStateTest, LeavesOnTiltAndComesBackVerified) {
  show(1.0, 0.0, 0.01);
  const Utime confirmed = state_.confirmed();
  show(0.1, 0.0, 0.1);
  EXPECT_EQ(state_.state(), ControlState::kH) << "a short knock";
  show(0.2, 0.0, 0.1);
  EXPECT_EQ(state_.state(), ControlState::kM);
  EXPECT_LE(state_.confirmed() - confirmed, kPicture) << "nothing is confirmed beyond the limits";
  show(0.3, 0.0, 0.01);
  EXPECT_EQ(state_.state(), ControlState::kM);
  show(0.3, 0.0, 0.01);
  EXPECT_EQ(state_.state(), ControlState::kR);
  scans(config_.verify_scans - 1, Scan::kAgrees);
  scans(1, Scan::kUnmatched);
  scans(config_.verify_scans - 1, Scan::kAgrees);
  EXPECT_EQ(state_.state(), ControlState::kR) << "in a row";
  scans(1, Scan::kAgrees);
  EXPECT_EQ(state_.state(), ControlState::kH);
}

TEST_F(PlaneStateTest, TiltBetweenBothLimitsDoesNotChatter) {
  show(1.0, 0.0, 0.01);
  show(2.0, 0.0, 1.1 * config_.largest_tilt);
  const auto revision = state_.revision();  // M, and R because so small a tilt may be an error.
  for (int i = 0; i < 20; ++i) {
    show(0.3, 0.0, 0.9 * config_.largest_tilt);
    show(0.3, 0.0, 1.1 * config_.largest_tilt);
  }
  EXPECT_EQ(state_.revision(), revision);
}

TEST_F(PlaneStateTest, LeavesOnHeight) {
  show(1.0, 0.0, 0.0);
  show(0.4, 0.3, 0.0);
  EXPECT_EQ(state_.state(), ControlState::kM);
}

TEST_F(PlaneStateTest, AnAttitudeThatMayBeWrongIsHeldAgainstTheScans) {
  show(1.0, 0.0, 0.0);
  show(0.5, 0.1, 0.08);
  ASSERT_EQ(state_.state(), ControlState::kM);
  show(1.0, 0.1, 0.08);
  EXPECT_EQ(state_.state(), ControlState::kR) << "a body nearly level: no ramp, perhaps a wrong attitude";
  show(5.0, 0.1, 0.08);
  EXPECT_EQ(state_.state(), ControlState::kR) << "until the scans decide";
  show(0.1, 0.1, 0.2);
  EXPECT_EQ(state_.state(), ControlState::kM);
  show(5.0, 0.5, 0.0);
  EXPECT_EQ(state_.state(), ControlState::kM) << "a platform";
}

TEST_F(PlaneStateTest, ContradictionLeadsToM) {
  show(1.0, 0.0, 0.0);
  scans(config_.contradictions - 1, Scan::kContradicts);
  EXPECT_EQ(state_.state(), ControlState::kH);
  scans(1, Scan::kContradicts);
  EXPECT_EQ(state_.state(), ControlState::kM);
  EXPECT_EQ(state_.contradicted(), 1);
}

TEST_F(PlaneStateTest, ASlopeThatMayHaveContradictedIsToldFromLevelGround) {
  for (const double body_tilt : {0.0, 0.1}) {
    show(1.0, 0.0, 0.0, true, body_tilt);
    scans(config_.contradictions, Scan::kContradicts);
    show(0.6, 0.0, 0.0);
    scans(config_.verify_scans, Scan::kAgrees);
    ASSERT_EQ(state_.state(), ControlState::kH);
    EXPECT_EQ(state_.contradictedOnLevelGround(), body_tilt == 0.0);
  }
}

TEST_F(PlaneStateTest, ALidarThatContradictsForLongIsBelievedInR) {
  show(1.0, 0.0, 0.0);
  scans(config_.contradictions, Scan::kContradicts);
  show(1.0, 0.0, 0.0);
  ASSERT_EQ(state_.state(), ControlState::kR);
  scans(100, Scan::kContradicts);
  ASSERT_EQ(state_.state(), ControlState::kR);
  scans(20, Scan::kContradicts);
  EXPECT_EQ(state_.state(), ControlState::kH);
}

TEST_F(PlaneStateTest, AnUnknownAttitudeSuspendsWritingUntilTheLidarHasShownIt) {
  show(1.0, 0.0, 0.0);
  show(0.1, 0.0, 0.0, false);
  EXPECT_EQ(state_.state(), ControlState::kR);
  scans(config_.verify_scans, Scan::kAgrees);
  EXPECT_EQ(state_.state(), ControlState::kR);
  scans(config_.observe_scans, Scan::kAgrees);
  EXPECT_EQ(state_.state(), ControlState::kH);
}

/// Ways up and down, and what stands at their ends.
class LevelsTest : public PlaneStateTest {
 protected:
  /// Over a slope to `height`, where the body stands level for `seconds`.
  void climbTo(double height, double seconds) {
    const double from = height_;
    for (int i = 1; i <= 30; ++i) {
      height_ = from + (height - from) * i / 30;
      show(0.1, height_, 0.0, true, 0.5);
    }
    show(seconds, height_, 0.0);
  }

  double height_ = 0.0;
};

TEST_F(LevelsTest, AFloorAtTheEndOfASlopeBecomesALevel) {
  show(1.0, 0.0, 0.0);
  climbTo(1.2, 0.8);
  EXPECT_EQ(state_.state(), ControlState::kM);
  const std::int64_t before = state_.revision();
  show(0.4, 1.2, 0.0);
  EXPECT_EQ(state_.state(), ControlState::kH);
  EXPECT_EQ(state_.levelId(), 1);
  EXPECT_NEAR(state_.level().floor, 1.2, 0.01);
  EXPECT_EQ(state_.revision(), before + 1);
  show(0.3, 1.5, 0.0);
  EXPECT_EQ(state_.state(), ControlState::kM) << "heights count from the level's floor";
}

TEST_F(LevelsTest, NoneWithoutASlopeNorOnStairs) {
  show(1.0, 0.0, 0.0);
  show(5.0, 1.2, 0.0);
  EXPECT_EQ(state_.state(), ControlState::kM) << "vision that has jumped";
  climbTo(0.9, 0.0);
  for (int step = 1; step <= 8; ++step) {
    show(0.5, 0.9 + 0.18 * step, 0.0);
  }
  EXPECT_EQ(state_.levels().size(), 1U);
}

TEST_F(LevelsTest, NoneWhereTheyAreSwitchedOffOrInThePapersMode) {
  for (const bool off : {true, false}) {
    config_ = {};
    config_.levels = !off;
    config_.mode = off ? "joint" : "lsm";
    state_ = PlaneState(config_);
    height_ = 0.0;
    show(1.0, 0.0, 0.0);
    climbTo(1.2, 5.0);
    EXPECT_EQ(state_.levels().size(), 1U);
    EXPECT_EQ(state_.state(), ControlState::kM);
  }
}

TEST_F(LevelsTest, KnownOnesAreReturnedToOnceScansAgree) {
  show(1.0, 0.0, 0.0);
  climbTo(1.2, 2.0);
  for (const int level : {0, 1, 0, 1}) {
    climbTo(level == 0 ? 0.03 : 1.17, 0.5);
    ASSERT_EQ(state_.state(), ControlState::kR);
    EXPECT_EQ(state_.levelId(), level);
    scans(config_.verify_scans, Scan::kAgrees);
    EXPECT_EQ(state_.state(), ControlState::kH);
  }
  EXPECT_EQ(state_.levels().size(), 2U);
}

TEST_F(LevelsTest, ScansThatDoNotMatchLeadToNoLevelAtAnotherHeight) {
  show(1.0, 0.0, 0.0);
  climbTo(0.8, 2.0);
  show(0.1, 0.8, 0.0, false);
  ASSERT_EQ(state_.state(), ControlState::kR) << "an unknown attitude";
  for (int i = 0; i < 10 * config_.observe_scans; ++i) {
    scans(1, Scan::kUnmatched);
    ASSERT_EQ(state_.levelId(), 1) << i;
  }
}

TEST_F(LevelsTest, OfTwoAtOneHeightTheScansTellWhich) {
  const int give_up = 3 * config_.observe_scans;
  show(1.0, 0.0, 0.0);
  climbTo(1.2, 2.0);
  climbTo(0.0, 0.5);
  scans(config_.verify_scans, Scan::kAgrees);
  climbTo(1.21, 2.0);
  ASSERT_EQ(state_.levelId(), 1);
  scans(give_up, Scan::kUnmatched);
  EXPECT_EQ(state_.levelId(), 2) << "another platform";
  EXPECT_EQ(state_.state(), ControlState::kH);
  climbTo(0.0, 0.5);
  scans(config_.verify_scans, Scan::kAgrees);
  climbTo(1.2, 2.0);
  ASSERT_EQ(state_.levelId(), 1);
  scans(give_up, Scan::kUnmatched);
  EXPECT_EQ(state_.levelId(), 2);
  EXPECT_EQ(state_.state(), ControlState::kR) << "that one again";
  scans(config_.verify_scans, Scan::kAgrees);
  EXPECT_EQ(state_.state(), ControlState::kH);
  EXPECT_EQ(state_.levels().size(), 3U);
}

TEST(PlaneStateLsm, SwitchesOnHeightAloneAndAtOnce) {
  PlaneStateConfig config;
  config.mode = "lsm";
  PlaneState state(config);
  state.addPlane(1'000'000, {0.0, 0.5}, true);
  state.addPlane(1'033'333, {0.0, 0.5}, true);
  EXPECT_EQ(state.state(), ControlState::kH) << "eq. 10 knows no tilt";
  state.addPlane(1'066'667, {0.26, 0.0}, true);
  EXPECT_EQ(state.state(), ControlState::kM);
  state.addPlane(1'100'000, {0.1, 0.0}, true);
  EXPECT_EQ(state.state(), ControlState::kR);
}

TEST(Levelling, AnglesMakeThePlateLevel) {
  const common::RobotConfig robot;
  for (const auto& [roll, pitch, yaw] :
       {std::array{0.0, 0.0, 0.0}, {0.2, 0.0, 1.0}, {0.0, -0.3, 2.0}, {-0.15, 0.25, -1.0}}) {
    const Eigen::Matrix3d R_world_body = common::rotationFromRpy({roll, pitch, yaw});
    const PlateAngles angles = levellingAngles(R_world_body, 0.5);
    const Eigen::Matrix3d R_world_plate =
        R_world_body * robot.T_body_plate(angles.roll, angles.pitch).linear();
    EXPECT_NEAR(R_world_plate(2, 2), 1.0, 1e-12);
  }
  const PlateAngles limited = levellingAngles(common::rotationFromRpy({0.0, 0.6, 0.0}), 0.35);
  EXPECT_DOUBLE_EQ(std::abs(limited.pitch), 0.35);
}

}  // namespace
}  // namespace rubble::fusion
