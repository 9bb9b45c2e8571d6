// What an emulated drive does not do: one drive whose other side is written down here.
#include "protocol/drive.h"

#include <gmock/gmock.h>

namespace rubble::stabilizer {
namespace {

using testing::HasSubstr;
using Kind = Problem::Kind;

constexpr Tick kCycle = 10'000;

class DriveTest : public testing::Test {
 protected:
  /// A cycle; SDOs are answered with what `values` says, else as done.
  void cycle() {
    now_ += kCycle;
    frames_.clear();
    drive_.cycle(now_, 0, frames_);
    for (const CanFrame& frame : frames_) {
      if (frame.id == 0x601) {
        CanFrame answer = frame;
        answer.id = 0x581;
        const bool is_read = frame.data[0] == 0x40;
        answer.data[0] = is_read ? 0x43 : 0x60;
        writeLittleEndian(is_read ? (frame.data[2] == 0x10 ? device_type_ : modes_) : 0,
                          std::span(answer.data).subspan(4));
        if (answers_sdo_) {
          drive_.receive(answer, now_);
        }
      } else if (frame.id == 0 && frame.data[0] == 0x82 && boots_) {
        heartbeat(0x00);
      } else if (frame.id == 0 && frame.data[0] == 0x01) {
        started_ = true;
      }
    }
    if (started_ && statusword_ >= 0) {
      heartbeat(0x05);
      CanFrame status{.id = 0x181, .size = 6};
      writeLittleEndian(static_cast<std::uint64_t>(statusword_), std::span(status.data).first(2));
      drive_.receive(status, now_);
    }
  }
  void heartbeat(std::uint8_t state) { drive_.receive({.id = 0x701, .data = {state}, .size = 1}, now_); }
  bool runUntil(Kind kind) {
    for (int i = 0; i < 2000 && drive_.status().problem.kind != kind; ++i) {
      cycle();
    }
    return drive_.status().problem.kind == kind;
  }

  Drive drive_{DriveOptions{}};
  Tick now_ = 0;
  std::vector<CanFrame> frames_;
  std::uint32_t device_type_ = 0x00020192;
  std::uint32_t modes_ = 0x80;
  bool boots_ = true;
  bool answers_sdo_ = true;
  bool started_ = false;
  int statusword_ = -1;
};

TEST_F(DriveTest, NoBootUp) {
  boots_ = false;
  EXPECT_TRUE(runUntil(Kind::kNoAnswer));
}

TEST_F(DriveTest, NoSdo) {
  answers_sdo_ = false;
  ASSERT_TRUE(runUntil(Kind::kSdoTimeout));
  EXPECT_THAT(describe(drive_.status().problem), HasSubstr("does not answer for object 0x1000:00"));
}

TEST_F(DriveTest, AnotherProfile) {
  device_type_ = 0x00030191;
  ASSERT_TRUE(runUntil(Kind::kNoDrive));
  EXPECT_THAT(describe(drive_.status().problem), HasSubstr("device type 0x00030191"));
}

TEST_F(DriveTest, AnotherMode) {
  modes_ = 0x01;
  EXPECT_TRUE(runUntil(Kind::kNoMode));
}

TEST_F(DriveTest, NoStatus) { EXPECT_TRUE(runUntil(Kind::kNoStatus)); }

TEST_F(DriveTest, ASafetySwitchThatIsOpen) {
  statusword_ = 0x0240;
  ASSERT_TRUE(runUntil(Kind::kNotEnabled));
  EXPECT_THAT(describe(drive_.status().problem), HasSubstr("stays in `switch on disabled`"));
  statusword_ = 0x0627;
  for (int i = 0; i < 5; ++i) {
    cycle();
  }
  EXPECT_TRUE(drive_.enabled());
  EXPECT_TRUE(drive_.status().solved);
}

TEST_F(DriveTest, AFaultReactionIsWaitedFor) {
  statusword_ = 0x0627;
  while (!drive_.enabled()) {
    cycle();
  }
  statusword_ = 0x060F;
  cycle();
  cycle();
  EXPECT_FALSE(drive_.enabled());
  EXPECT_EQ(frames_.at(0).data[0], 0x00);
  statusword_ = 0x0608;
  EXPECT_TRUE(runUntil(Kind::kFault));
}

TEST(Problem, EveryKindIsSaidInWords) {
  for (int kind = 1; kind <= static_cast<int>(Kind::kNotFollowing); ++kind) {
    EXPECT_NE(describe({.kind = static_cast<Kind>(kind)}), "") << kind;
  }
}

}  // namespace
}  // namespace rubble::stabilizer
