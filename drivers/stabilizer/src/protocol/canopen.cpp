#include "protocol/canopen.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

namespace rubble::stabilizer {

namespace {

using CodeText = std::pair<std::uint16_t, const char*>;

// Exact codes first, then what their high byte, at last what their highest digit means.
constexpr std::array kCodes = {CodeText{0x2310, "continuous over-current"},
                               CodeText{0x2320, "short circuit"},
                               CodeText{0x3210, "DC link over-voltage"},
                               CodeText{0x3220, "DC link under-voltage"},
                               CodeText{0x4210, "drive too hot"},
                               CodeText{0x4310, "drive too hot"},
                               CodeText{0x5441, "contact 1 open: safe torque off?"},
                               CodeText{0x7121, "motor blocked"},
                               CodeText{0x7305, "encoder 1"},
                               CodeText{0x7306, "encoder 2"},
                               CodeText{0x8110, "CAN overrun"},
                               CodeText{0x8120, "CAN error passive"},
                               CodeText{0x8130, "heartbeat or life guard error"},
                               CodeText{0x8140, "recovered from bus-off"},
                               CodeText{0x8150, "CAN identifier collision"},
                               CodeText{0x8210, "PDO not processed: wrong length"},
                               CodeText{0x8250, "RPDO timeout"},
                               CodeText{0x8611, "following error"},
                               CodeText{0x8612, "reference limit"}};
constexpr std::array kGroups = {CodeText{0x2100, "current on the input side"},
                                CodeText{0x2200, "current inside the drive"},
                                CodeText{0x2300, "current on the output side"},
                                CodeText{0x3100, "mains voltage"},
                                CodeText{0x3200, "voltage inside the drive"},
                                CodeText{0x3300, "output voltage"},
                                CodeText{0x8100, "communication"},
                                CodeText{0x8600, "position controller"}};
constexpr std::array kClasses = {CodeText{0x0000, "error gone"},
                                 CodeText{0x1000, "generic error"},
                                 CodeText{0x2000, "current"},
                                 CodeText{0x3000, "voltage"},
                                 CodeText{0x4000, "temperature"},
                                 CodeText{0x5000, "hardware"},
                                 CodeText{0x6000, "software"},
                                 CodeText{0x7000, "sensor or motor"},
                                 CodeText{0x8000, "monitoring"},
                                 CodeText{0x9000, "external error"},
                                 CodeText{0xF000, "additional functions"}};

const char* textOf(std::span<const CodeText> texts, int code) {
  const auto found =
      std::find_if(texts.begin(), texts.end(), [code](const CodeText& text) { return text.first == code; });
  return found == texts.end() ? nullptr : found->second;
}

}  // namespace

std::uint64_t readLittleEndian(std::span<const std::uint8_t> bytes) {
  std::uint64_t value = 0;
  for (std::size_t i = bytes.size(); i-- > 0;) {
    value = value << 8 | bytes[i];
  }
  return value;
}

void writeLittleEndian(std::uint64_t value, std::span<std::uint8_t> bytes) {
  for (std::uint8_t& byte : bytes) {
    byte = static_cast<std::uint8_t>(value);
    value >>= 8;
  }
}

CanFrame nmtFrame(NmtCommand command, int node) {
  return {.id = cob::kNmt,
          .data = {static_cast<std::uint8_t>(command), static_cast<std::uint8_t>(node)},
          .size = 2};
}

std::optional<NmtState> readHeartbeat(const CanFrame& frame) {
  if (frame.size != 1) {
    return std::nullopt;
  }
  // Bit 7 is node guarding's toggle bit, which a heartbeat leaves 0.
  const auto state = static_cast<NmtState>(frame.data[0]);
  switch (state) {
    case NmtState::kBootUp:
    case NmtState::kStopped:
    case NmtState::kOperational:
    case NmtState::kPreOperational:
      return state;
  }
  return std::nullopt;
}

CanFrame syncFrame() { return {.id = cob::kSync}; }

std::optional<Emergency> readEmergency(const CanFrame& frame) {
  if (frame.size != 8) {
    return std::nullopt;
  }
  return Emergency{static_cast<std::uint16_t>(readLittleEndian(frame.bytes().first(2))), frame.data[2]};
}

std::string describeEmergency(std::uint16_t code) {
  const char* text = textOf(kCodes, code);
  text = text == nullptr ? textOf(kGroups, code & 0xFF00) : text;
  text = text == nullptr ? textOf(kClasses, code & 0xF000) : text;
  return fmt::format("0x{:04X} ({})", code, text == nullptr ? "the manual of the drive knows it" : text);
}

CanFrame setPointFrame(int node, std::uint16_t controlword, std::int32_t target) {
  CanFrame frame{.id = cob::kSetPoint + static_cast<std::uint32_t>(node), .size = 6};
  writeLittleEndian(controlword, std::span(frame.data).first(2));
  writeLittleEndian(static_cast<std::uint32_t>(target), std::span(frame.data).subspan(2, 4));
  return frame;
}

std::optional<DriveReading> readStatus(const CanFrame& frame) {
  if (frame.size != 6) {
    return std::nullopt;
  }
  return DriveReading{
      static_cast<std::uint16_t>(readLittleEndian(frame.bytes().first(2))),
      static_cast<std::int32_t>(static_cast<std::uint32_t>(readLittleEndian(frame.bytes().subspan(2))))};
}

}  // namespace rubble::stabilizer
