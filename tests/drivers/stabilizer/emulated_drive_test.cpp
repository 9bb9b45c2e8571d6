// The emulated drive is held to the standards, not to the driver.
#include "emulated_drive.h"

#include <gmock/gmock.h>

#include <cmath>

namespace rubble::stabilizer {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

class EmulatedDriveTest : public testing::Test {
 protected:
  std::vector<CanFrame> send(const CanFrame& frame) {
    std::vector<CanFrame> answers;
    drive_.receive(frame, now_, answers);
    return answers;
  }
  std::vector<CanFrame> advance(Tick by) {
    std::vector<CanFrame> frames;
    drive_.advance(now_ += by, frames);
    return frames;
  }
  std::uint32_t write(const ObjectEntry& entry, std::uint32_t value, int bytes) {
    const auto answer = readSdoAnswer(send(sdoDownloadFrame(5, entry, value, bytes)).at(0));
    return answer->kind == SdoAnswer::Kind::kAborted ? answer->value : 0;
  }

  Tick now_ = 0;
  EmulatedDrive drive_{5, {.speed = 2.0, .acceleration = 20.0}};
};

TEST_F(EmulatedDriveTest, BootsThenBeatsAsItIsTold) {
  EXPECT_THAT(send(sdoUploadFrame(5, {0x1000, 0})), IsEmpty()) << "it is still booting";
  const auto boot = advance(0);
  ASSERT_EQ(boot.size(), 1U);
  EXPECT_EQ(boot[0].id, 0x705U);
  EXPECT_EQ(boot[0].data[0], 0x00);
  EXPECT_THAT(advance(1'000'000), IsEmpty()) << "0x1017 is 0";
  EXPECT_EQ(write({0x1017, 0}, 100, 2), 0U);
  EXPECT_EQ(advance(0).at(0).data[0], 0x7F);
  EXPECT_THAT(advance(99'000), IsEmpty());
  send(nmtFrame(NmtCommand::kStart, 5));
  EXPECT_EQ(advance(1'000).at(0).data[0], 0x05);
  send(nmtFrame(NmtCommand::kStop, 0));
  EXPECT_EQ(advance(100'000).at(0).data[0], 0x04) << "node 0 is all nodes";
  EXPECT_THAT(send(sdoUploadFrame(5, {0x1000, 0})), IsEmpty()) << "no SDO while it is stopped";
}

TEST_F(EmulatedDriveTest, SdoAnswersByteForByte) {
  advance(0);
  const auto identity = send(sdoUploadFrame(5, {0x1000, 0})).at(0);
  EXPECT_EQ(identity.id, 0x585U);
  EXPECT_THAT(identity.data, ElementsAre(0x43, 0x00, 0x10, 0x00, 0x92, 0x01, 0x02, 0x00));
  EXPECT_THAT(send(sdoUploadFrame(5, {0x1017, 0})).at(0).data, ElementsAre(0x4B, 0x17, 0x10, 0, 0, 0, 0, 0));
  EXPECT_THAT(send(sdoDownloadFrame(5, {0x6060, 0}, 8, 1)).at(0).data,
              ElementsAre(0x60, 0x60, 0x60, 0, 0, 0, 0, 0));
  EXPECT_EQ(write({0x2000, 0}, 0, 4), 0x06020000U);
  EXPECT_EQ(write({0x1017, 1}, 0, 2), 0x06090011U);
  EXPECT_EQ(write({0x1017, 0}, 0, 4), 0x06070010U);
  EXPECT_EQ(write({0x6041, 0}, 0, 2), 0x06010002U);
  EXPECT_EQ(write({0x6060, 0}, 5, 1), 0x06090030U);
}

TEST_F(EmulatedDriveTest, MapsPdosOnlyAsTheStandardWants) {
  advance(0);
  EXPECT_EQ(write({0x1A00, 1}, 0x60410010U, 4), 0U);
  EXPECT_EQ(write({0x1A00, 2}, 0x99990010U, 4), 0x06040041U) << "no such object";
  EXPECT_EQ(write({0x1A00, 2}, 0x60640010U, 4), 0x06040041U) << "another length";
  EXPECT_EQ(write({0x1A00, 2}, 0x60640020U, 4), 0U);
  EXPECT_EQ(write({0x1A00, 3}, 0x60640020U, 4), 0U);
  EXPECT_EQ(write({0x1A00, 0}, 3, 1), 0x06040042U) << "80 bits";
  EXPECT_EQ(write({0x1A00, 0}, 2, 1), 0U);
  EXPECT_EQ(write({0x1A00, 1}, 0x60640020U, 4), 0x08000022U) << "it is not emptied";
  EXPECT_EQ(write({0x1800, 1}, 0x185, 4), 0U);
  EXPECT_EQ(write({0x1A00, 0}, 0, 1), 0x08000022U) << "it is on";
  EXPECT_THAT(send(syncFrame()), IsEmpty()) << "not operational";
  send(nmtFrame(NmtCommand::kStart, 5));
  const auto status = send(syncFrame());
  ASSERT_EQ(status.size(), 1U);
  EXPECT_EQ(status[0].id, 0x185U);
  EXPECT_EQ(status[0].size, 6);
  EXPECT_EQ(status[0].data[0] & 0x4F, 0x40) << "switch on disabled";
}

TEST(EmulatedMotor, KeepsToSpeedAndAcceleration) {
  EmulatedMotor motor(2.0, 20.0);
  double last = 0.0;
  double last_speed = 0.0;
  for (Tick now = 1000; now <= 1'500'000; now += 1000) {
    motor.advance(now, 1.0);
    const double speed = (motor.position() - last) * 1000.0;
    EXPECT_LE(std::abs(speed), 2.0 + 1e-9);
    EXPECT_LE(std::abs(speed - last_speed), 20.0 * 0.001 + 1e-9);
    last = motor.position();
    last_speed = speed;
  }
  EXPECT_NEAR(motor.position(), 1.0, 1e-4);
}

}  // namespace
}  // namespace rubble::stabilizer
