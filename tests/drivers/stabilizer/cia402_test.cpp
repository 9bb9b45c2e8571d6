#include "protocol/cia402.h"

#include <gtest/gtest.h>

#include <string>

namespace rubble::stabilizer {
namespace {

TEST(Cia402, StatuswordsOfTheStandard) {
  // Bits that do not belong to the state are set in the second of each pair.
  EXPECT_EQ(stateOf(0x0000), DriveState::kNotReady);
  EXPECT_EQ(stateOf(0x1620), DriveState::kNotReady);
  EXPECT_EQ(stateOf(0x0040), DriveState::kSwitchOnDisabled);
  EXPECT_EQ(stateOf(0x0670), DriveState::kSwitchOnDisabled);
  EXPECT_EQ(stateOf(0x0021), DriveState::kReadyToSwitchOn);
  EXPECT_EQ(stateOf(0x0631), DriveState::kReadyToSwitchOn);
  EXPECT_EQ(stateOf(0x0023), DriveState::kSwitchedOn);
  EXPECT_EQ(stateOf(0x0633), DriveState::kSwitchedOn);
  EXPECT_EQ(stateOf(0x0027), DriveState::kOperationEnabled);
  EXPECT_EQ(stateOf(0x1637), DriveState::kOperationEnabled);
  EXPECT_EQ(stateOf(0x0007), DriveState::kQuickStopActive);
  EXPECT_EQ(stateOf(0x0617), DriveState::kQuickStopActive);
  EXPECT_EQ(stateOf(0x000F), DriveState::kFaultReaction);
  EXPECT_EQ(stateOf(0x002F), DriveState::kFaultReaction);
  EXPECT_EQ(stateOf(0x0008), DriveState::kFault);
  EXPECT_EQ(stateOf(0x0638), DriveState::kFault);
}

TEST(Cia402, EveryStatuswordHasAState) {
  for (int word = 0; word <= 0xFFFF; ++word) {
    EXPECT_NE(std::string(toString(stateOf(static_cast<std::uint16_t>(word)))), "");
  }
}

TEST(Cia402, TheWayToEnabled) {
  EXPECT_EQ(commandTowardsEnabled(DriveState::kSwitchOnDisabled), 0x06);
  EXPECT_EQ(commandTowardsEnabled(DriveState::kReadyToSwitchOn), 0x07);
  EXPECT_EQ(commandTowardsEnabled(DriveState::kSwitchedOn), 0x0F);
  EXPECT_EQ(commandTowardsEnabled(DriveState::kOperationEnabled), 0x0F);
  EXPECT_EQ(commandTowardsEnabled(DriveState::kQuickStopActive), 0x00) << "through switch on disabled";
  EXPECT_EQ(commandTowardsEnabled(DriveState::kFault), 0x00);
  EXPECT_EQ(commandTowardsEnabled(DriveState::kNotReady), 0x00);
}

}  // namespace
}  // namespace rubble::stabilizer
