#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "protocol/can_frame.h"

namespace rubble::stabilizer {

/// Function codes of the predefined connection set (CiA 301 section 7.3.3): COB-ID = function + node.
namespace cob {
inline constexpr std::uint32_t kNmt = 0x000;
inline constexpr std::uint32_t kSync = 0x080;
inline constexpr std::uint32_t kEmergency = 0x080;
inline constexpr std::uint32_t kStatus = 0x180;    // TPDO1
inline constexpr std::uint32_t kSetPoint = 0x200;  // RPDO1
inline constexpr std::uint32_t kSdoAnswer = 0x580;
inline constexpr std::uint32_t kSdoRequest = 0x600;
inline constexpr std::uint32_t kHeartbeat = 0x700;
}  // namespace cob

/// Little-endian, as all of CANopen (section 7.1.4.2); at most 8 bytes.
std::uint64_t readLittleEndian(std::span<const std::uint8_t> bytes);
void writeLittleEndian(std::uint64_t value, std::span<std::uint8_t> bytes);

/// NMT commands (section 7.2.8.3.1).
enum class NmtCommand : std::uint8_t {
  kStart = 0x01,
  kStop = 0x02,
  kEnterPreOperational = 0x80,
  kResetNode = 0x81,
  kResetCommunication = 0x82,
};
CanFrame nmtFrame(NmtCommand command, int node);

/// What a heartbeat says (section 7.2.8.3.2.2).
enum class NmtState : std::uint8_t {
  kBootUp = 0x00,
  kStopped = 0x04,
  kOperational = 0x05,
  kPreOperational = 0x7F,
};
/// Empty for a frame that is no heartbeat.
std::optional<NmtState> readHeartbeat(const CanFrame& frame);

/// Without counter (section 7.2.5).
CanFrame syncFrame();

/// EMCY (section 7.2.7): error code, error register and what the manufacturer adds.
struct Emergency {
  /// 0: the error is gone.
  std::uint16_t code = 0;
  std::uint8_t error_register = 0;
};
/// Empty for a frame that is none.
std::optional<Emergency> readEmergency(const CanFrame& frame);

/// In words, e.g. `0x8611 (following error)` (CiA 301 table 26, CiA 402-2 annex on error codes).
std::string describeEmergency(std::uint16_t code);

/// Controlword and target position, as the RPDO is mapped; increments of the drive.
CanFrame setPointFrame(int node, std::uint16_t controlword, std::int32_t target);

/// Statusword and actual position, as the TPDO is mapped; increments of the drive.
struct DriveReading {
  std::uint16_t statusword = 0;
  std::int32_t position = 0;
};
/// Empty for a frame of another size.
std::optional<DriveReading> readStatus(const CanFrame& frame);

}  // namespace rubble::stabilizer
