// The pair of drives against the emulated ones in virtual time: every fault, exactly when it happens.
#include "protocol/drive_pair.h"

#include <gmock/gmock.h>
#include <linux/can/error.h>

#include <cmath>

#include "common/error.h"
#include "emulated_drive.h"
#include "support/error_text.h"

namespace rubble::stabilizer {
namespace {

using testing::HasSubstr;
using Kind = Problem::Kind;

constexpr Tick kCycle = 10'000;
constexpr common::Utime kEpoch = 1'700'000'000'000'000;
constexpr double kZero = 0.1;  // The plate's roll where the drive counts 0.

class DrivePairTest : public testing::TestWithParam<Mode> {
 protected:
  DrivePairTest() : pair_(options()), drives_{EmulatedDrive(1, {}), EmulatedDrive(2, {})} {
    pair_.restart(now_);
  }

  static DrivePair::Options options() {
    const double increments = EmulatedModel().increments_per_rad;
    const auto axis = [&](int node) {
      return AxisOptions{
          .drive = {.setup = {.node = node,
                              .mode = GetParam(),
                              .profile_velocity = static_cast<std::uint32_t>(2.5 * increments)},
                    .following_error = std::llround(0.15 * increments)},
          .rad_per_increment = 1.0 / increments};
    };
    DrivePair::Options options{
        .axes = {axis(1), axis(2)},
        .limits = {.lowest = {-0.35, -0.35}, .highest = {0.35, 0.35}, .rate = {2.5, 2.5}}};
    options.axes[0].zero_offset = kZero;
    options.axes[1].rad_per_increment *= -1.0;
    return options;
  }

  common::Utime utime() const { return kEpoch + now_; }

  void deliver(std::vector<CanFrame> answers) {
    for (CanFrame& answer : answers) {
      answer.utime = utime() + 500;
      if (const auto reading = pair_.receive(answer, now_ + 500)) {
        reading_ = *reading;
        ++readings_;
      }
    }
  }

  void cycle() {
    now_ += kCycle;
    std::vector<CanFrame> answers;
    for (const CanFrame& frame : pair_.cycle(now_, utime())) {
      for (EmulatedDrive& drive : drives_) {
        drive.receive(frame, now_, answers);
      }
    }
    for (EmulatedDrive& drive : drives_) {
      drive.advance(now_, answers);
    }
    deliver(answers);
  }

  template <typename Condition>
  bool runUntil(const Condition& condition, double seconds = 10.0) {
    const Tick end = now_ + common::utimeFromSeconds(seconds);
    while (!condition() && now_ < end) {
      cycle();
    }
    return condition();
  }
  void run(double seconds) {
    runUntil([] { return false; }, seconds);
  }
  bool start() {
    return runUntil([&] { return pair_.status().enabled; });
  }
  void inject(std::size_t axis, DriveFault fault) {
    std::vector<CanFrame> frames;
    drives_[axis].inject(fault, frames);
    deliver(frames);
  }
  void command(double roll, double pitch, double valid = 0.2) {
    pair_.command({utime(), utime() + common::utimeFromSeconds(valid), {roll, pitch}, {}}, utime());
  }
  const DriveStatus& drive(std::size_t axis) const { return pair_.status().drives[axis]; }
  bool recovers(std::size_t axis, Kind kind) {
    return runUntil([&] { return drive(axis).problem.kind == kind && !drive(axis).solved; }) &&
           runUntil([&] { return pair_.status().enabled && drive(axis).solved; });
  }

  Tick now_ = 1'000'000;
  DrivePair pair_;
  std::array<EmulatedDrive, 2> drives_;
  PlateReading reading_;
  int readings_ = 0;
};

INSTANTIATE_TEST_SUITE_P(Modes, DrivePairTest,
                         testing::Values(Mode::kCyclicSynchronousPosition, Mode::kProfilePosition),
                         [](const auto& mode) {
                           return mode.param == Mode::kProfilePosition ? "ProfilePosition" : "CyclicPosition";
                         });

TEST_P(DrivePairTest, StartsUpWithoutAProblemAndHoldsWhereThePlateIs) {
  ASSERT_TRUE(start());
  EXPECT_LT(now_, 1'000'000 + 1'000'000);
  run(1.0);
  for (const DriveStatus& status : pair_.status().drives) {
    EXPECT_EQ(status.problem.kind, Kind::kNone);
    EXPECT_EQ(status.failures, 0);
    EXPECT_EQ(status.unexpected, 0);
  }
  EXPECT_NEAR(reading_.angles[0], kZero, 1e-4);
  EXPECT_NEAR(reading_.angles[1], 0.0, 1e-4);
  EXPECT_EQ(reading_.command_utime, 0);
  EXPECT_FALSE(pair_.status().following);
  const int before = readings_;
  run(1.0);
  EXPECT_EQ(readings_, before + 100) << "one reading a cycle";
  EXPECT_EQ(reading_.utime, utime() + 500) << "stamped when its TPDO came";
}

TEST_P(DrivePairTest, FollowsACommandAndMeasuresTheTurn) {
  ASSERT_TRUE(start());
  run(0.1);
  double fastest = 0.0;
  common::Utime followed = 0;
  ASSERT_TRUE(runUntil([&] {
    command(-0.2, 0.3);
    fastest = std::max(fastest, reading_.rates[1]);
    followed = std::max(followed, reading_.command_utime);
    return std::abs(reading_.angles[0] + 0.2) < 1e-3 && std::abs(reading_.angles[1] - 0.3) < 1e-3;
  }));
  EXPECT_LT(utime() - followed, 30'000);
  EXPECT_GT(fastest, 1.0);
  EXPECT_LT(fastest, 2.6);
  EXPECT_NEAR(drives_[1].position(), -0.3 * EmulatedModel().increments_per_rad, 300.0) << "it is reversed";
}

TEST_P(DrivePairTest, AnExpiredCommandHolds) {
  ASSERT_TRUE(start());
  run(0.1);
  pair_.command({utime(), utime() + 100'000, {kZero, 0.0}, {0.0, 0.5}}, utime());
  run(0.5);
  EXPECT_FALSE(pair_.status().following);
  EXPECT_EQ(reading_.command_utime, 0);
  EXPECT_NEAR(reading_.angles[1], 0.05, 0.006);
  const double held = reading_.angles[1];
  run(1.0);
  EXPECT_NEAR(reading_.angles[1], held, 1e-4);
  pair_.command({utime() - 500'000, utime() - 1, {0.3, 0.3}, {}}, utime());
  run(0.1);
  EXPECT_NEAR(reading_.angles[1], held, 1e-4);
  EXPECT_EQ(pair_.status().commands_refused, 1);
}

TEST_P(DrivePairTest, ALimitHoldsThereAndIsSaidForTenSeconds) {
  ASSERT_TRUE(start());
  ASSERT_TRUE(runUntil([&] {
    command(kZero, -1.0);
    return std::abs(reading_.angles[1] + 0.35) < 1e-3;
  }));
  EXPECT_FALSE(pair_.status().limited[0]);
  EXPECT_TRUE(pair_.status().limited[1]);
  run(9.0);
  EXPECT_TRUE(pair_.status().limited[1]);
  run(2.0);
  EXPECT_FALSE(pair_.status().limited[1]);
  EXPECT_NEAR(reading_.angles[1], -0.35, 1e-3);
}

TEST_P(DrivePairTest, AFaultHoldsTheOtherAxisAndIsReset) {
  ASSERT_TRUE(start());
  run(0.1);
  command(kZero, 0.3);
  run(0.06);
  inject(0, DriveFault::kFault);
  run(0.02);
  ASSERT_FALSE(pair_.status().enabled);
  EXPECT_EQ(drive(0).problem.kind, Kind::kFault);
  EXPECT_EQ(drive(0).problem.code, 0x8611U);
  EXPECT_EQ(describe(drive(0).problem), "has fault 0x8611 (following error); it is reset");
  EXPECT_EQ(drive(1).problem.kind, Kind::kNone);
  run(0.1);
  const double held = reading_.angles[1];
  EXPECT_LT(held, 0.25);
  EXPECT_EQ(reading_.command_utime, 0);
  cycle();
  EXPECT_NEAR(reading_.angles[1], held, 1e-3);
  ASSERT_TRUE(runUntil([&] { return pair_.status().enabled; }));
  EXPECT_TRUE(drive(0).solved);
  EXPECT_EQ(drive(0).fault_resets, 1);
  EXPECT_EQ(drive(0).problem.code, 0x8611U) << "it can still be read what it was";
  run(11.0);
  EXPECT_EQ(drive(0).problem.kind, Kind::kNone);
}

TEST_P(DrivePairTest, AFaultThatStaysIsResetSoOftenAndNoMore) {
  ASSERT_TRUE(start());
  inject(1, DriveFault::kLastingFault);
  ASSERT_TRUE(runUntil([&] { return drive(1).problem.kind == Kind::kFaultForGood; }, 60.0));
  EXPECT_EQ(drive(1).fault_resets, 5);
  run(60.0);
  EXPECT_EQ(drive(1).fault_resets, 5);
  EXPECT_THAT(describe(drive(1).problem), HasSubstr("switch it off and on"));
  const int before = readings_;
  run(1.0);
  EXPECT_EQ(readings_, before + 100) << "where the plate is is measured on";
  inject(1, DriveFault::kOn);
  EXPECT_TRUE(runUntil([&] { return pair_.status().enabled; })) << "it was switched off and on";
  inject(1, DriveFault::kFault);
  EXPECT_TRUE(recovers(1, Kind::kFault)) << "and may be reset again";
}

TEST_P(DrivePairTest, ALostHeartbeatIsNoticedAndTheDriveSetUpAnew) {
  ASSERT_TRUE(start());
  inject(0, DriveFault::kSilence);
  const Tick begin = now_;
  ASSERT_TRUE(runUntil([&] { return drive(0).problem.kind == Kind::kHeartbeat; }));
  EXPECT_NEAR(static_cast<double>(now_ - begin), 350'000, 110'000);
  EXPECT_TRUE(recovers(0, Kind::kHeartbeat));
  EXPECT_EQ(drive(0).failures, 1);
}

TEST_P(DrivePairTest, ADriveWithoutPowerIsTriedUntilItIsThere) {
  inject(0, DriveFault::kOff);
  run(20.0);
  EXPECT_EQ(drive(0).problem.kind, Kind::kNoAnswer);
  EXPECT_LT(drive(0).failures, 12) << "pauses grow";
  inject(0, DriveFault::kOn);
  EXPECT_TRUE(runUntil([&] { return pair_.status().enabled; }, 2.0)) << "its boot-up is enough";
}

TEST_P(DrivePairTest, ARestartedDriveIsSetUpAnew) {
  ASSERT_TRUE(start());
  inject(1, DriveFault::kOff);
  run(0.05);
  inject(1, DriveFault::kOn);
  EXPECT_TRUE(recovers(1, Kind::kRestarted));
}

TEST_P(DrivePairTest, AWrongSdoAnswerIsAskedForAgain) {
  ASSERT_TRUE(start());
  inject(0, DriveFault::kWrongSdo);
  ASSERT_TRUE(runUntil([&] { return drive(0).unexpected == 1; }));
  EXPECT_TRUE(runUntil([&] { return pair_.status().enabled; }, 2.0));
}

TEST_P(DrivePairTest, ARefusedObjectIsNamed) {
  ASSERT_TRUE(start());
  inject(0, DriveFault::kSdoAbort);
  ASSERT_TRUE(runUntil([&] { return drive(0).problem.kind == Kind::kSdoAbort; }));
  EXPECT_THAT(describe(drive(0).problem),
              HasSubstr("refuses object 0x1017:00 with abort 0x06090030 (value out of range)"));
  EXPECT_TRUE(recovers(0, Kind::kSdoAbort));
}

TEST_P(DrivePairTest, ABlockedAxisIsSaidWhileItIs) {
  ASSERT_TRUE(start());
  inject(1, DriveFault::kStuck);
  const auto wish = [&] {
    command(kZero, 0.3);
    return drive(1).problem.kind == Kind::kNotFollowing;
  };
  ASSERT_TRUE(runUntil(wish));
  EXPECT_FALSE(drive(1).solved);
  EXPECT_TRUE(pair_.status().enabled);
  inject(1, DriveFault::kFree);
  EXPECT_TRUE(runUntil([&] { return drive(1).solved; }));
}

TEST_P(DrivePairTest, StoppingIsAQuickStopAndTheNextStartEnablesAgain) {
  ASSERT_TRUE(start());
  command(kZero, 0.3, 10.0);
  run(0.06);
  std::vector<CanFrame> answers;
  for (const CanFrame& frame : pair_.stop()) {
    for (EmulatedDrive& drive : drives_) {
      drive.receive(frame, now_, answers);
    }
  }
  EXPECT_EQ(stateOf(readStatus(answers.back())->statusword), DriveState::kQuickStopActive);
  pair_.restart(now_);
  EXPECT_TRUE(runUntil([&] { return pair_.status().enabled; }));
}

TEST_P(DrivePairTest, BusErrorsAreSaidAndBusOffEndsIt) {
  ASSERT_TRUE(start());
  pair_.receive({.id = CAN_ERR_ACK, .size = 8, .is_error = true}, now_);
  cycle();
  EXPECT_EQ(pair_.status().bus_error, BusError::kNoAcknowledge);
  run(11.0);
  EXPECT_EQ(pair_.status().bus_error, BusError::kNone);
  EXPECT_THAT(
      test::errorOf([&] { pair_.receive({.id = CAN_ERR_BUSOFF, .size = 8, .is_error = true}, now_); }),
      HasSubstr("is bus-off"));
}

}  // namespace
}  // namespace rubble::stabilizer
