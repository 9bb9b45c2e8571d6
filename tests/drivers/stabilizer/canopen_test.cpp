// Vectors written down by hand from CiA 301.
#include "protocol/canopen.h"

#include <gmock/gmock.h>
#include <linux/can/error.h>

#include "protocol/bus_error.h"

namespace rubble::stabilizer {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::vector<int> bytesOf(const CanFrame& frame) { return {frame.bytes().begin(), frame.bytes().end()}; }

TEST(CanOpen, NmtCommandsNameTheNode) {
  const CanFrame start = nmtFrame(NmtCommand::kStart, 5);
  EXPECT_EQ(start.id, 0U);
  EXPECT_THAT(bytesOf(start), ElementsAre(0x01, 5));
  EXPECT_THAT(bytesOf(nmtFrame(NmtCommand::kResetCommunication, 127)), ElementsAre(0x82, 127));
  EXPECT_THAT(bytesOf(nmtFrame(NmtCommand::kResetNode, 1)), ElementsAre(0x81, 1));
}

TEST(CanOpen, SyncIsEmpty) {
  EXPECT_EQ(syncFrame().id, 0x80U);
  EXPECT_EQ(syncFrame().size, 0);
}

TEST(CanOpen, HeartbeatsSayTheState) {
  const auto heartbeat = [](std::uint8_t byte, std::uint8_t size = 1) {
    return readHeartbeat({.id = 0x701, .data = {byte}, .size = size});
  };
  EXPECT_EQ(heartbeat(0x00), NmtState::kBootUp);
  EXPECT_EQ(heartbeat(0x04), NmtState::kStopped);
  EXPECT_EQ(heartbeat(0x05), NmtState::kOperational);
  EXPECT_EQ(heartbeat(0x7F), NmtState::kPreOperational);
  EXPECT_EQ(heartbeat(0x85), std::nullopt) << "node guarding";
  EXPECT_EQ(heartbeat(0x05, 2), std::nullopt);
  EXPECT_EQ(heartbeat(0x00, 0), std::nullopt);
}

TEST(CanOpen, EmergenciesAreReadAndPutIntoWords) {
  const auto emergency = readEmergency({.id = 0x81, .data = {0x11, 0x86, 0x21, 1, 2, 3, 4, 5}, .size = 8});
  ASSERT_TRUE(emergency);
  EXPECT_EQ(emergency->code, 0x8611);
  EXPECT_EQ(emergency->error_register, 0x21);
  EXPECT_EQ(readEmergency({.id = 0x81, .size = 7}), std::nullopt);
  EXPECT_EQ(describeEmergency(0x8611), "0x8611 (following error)");
  EXPECT_EQ(describeEmergency(0x3220), "0x3220 (DC link under-voltage)");
  EXPECT_EQ(describeEmergency(0x2399), "0x2399 (current on the output side)") << "by its group";
  EXPECT_EQ(describeEmergency(0x4FFF), "0x4FFF (temperature)") << "by its class";
  EXPECT_THAT(describeEmergency(0xA001), HasSubstr("manual"));
}

TEST(CanOpen, PdosAreLittleEndian) {
  const CanFrame frame = setPointFrame(2, 0x000F, -2);
  EXPECT_EQ(frame.id, 0x202U);
  EXPECT_THAT(bytesOf(frame), ElementsAre(0x0F, 0x00, 0xFE, 0xFF, 0xFF, 0xFF));
  const auto reading = readStatus({.id = 0x182, .data = {0x37, 0x12, 0x00, 0x00, 0x00, 0x80}, .size = 6});
  ASSERT_TRUE(reading);
  EXPECT_EQ(reading->statusword, 0x1237);
  EXPECT_EQ(reading->position, INT32_MIN);
  EXPECT_EQ(readStatus({.id = 0x182, .size = 8}), std::nullopt);
}

TEST(BusErrors, AreToldApart) {
  const auto error = [](std::uint32_t classes, std::uint8_t controller = 0) {
    return busErrorOf({.id = classes, .data = {0, controller}, .size = 8, .is_error = true});
  };
  EXPECT_EQ(error(CAN_ERR_BUSOFF), BusError::kBusOff);
  EXPECT_EQ(error(CAN_ERR_ACK), BusError::kNoAcknowledge);
  EXPECT_EQ(error(CAN_ERR_CRTL, CAN_ERR_CRTL_TX_PASSIVE), BusError::kWarning);
  EXPECT_EQ(error(CAN_ERR_CRTL, CAN_ERR_CRTL_RX_OVERFLOW), BusError::kOverflow);
  EXPECT_EQ(error(CAN_ERR_CRTL, CAN_ERR_CRTL_ACTIVE), BusError::kNone) << "it is well again";
  EXPECT_EQ(error(CAN_ERR_RESTARTED), BusError::kNone);
}

}  // namespace
}  // namespace rubble::stabilizer
