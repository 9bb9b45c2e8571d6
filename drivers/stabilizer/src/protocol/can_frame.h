#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "common/time.h"

namespace rubble::stabilizer {

/// A classic CAN frame (ISO 11898-1) with an 11-bit identifier, or an error frame of SocketCAN.
struct CanFrame {
  std::uint32_t id = 0;
  std::array<std::uint8_t, 8> data{};
  std::uint8_t size = 0;
  /// SocketCAN's error frame: `id` holds the CAN_ERR_* classes.
  bool is_error = false;
  /// When it was received, by the host's clock; 0 in frames to send.
  common::Utime utime = 0;

  std::span<const std::uint8_t> bytes() const { return std::span(data).first(size); }
};

}  // namespace rubble::stabilizer
