#pragma once

#include <memory>
#include <span>
#include <string>

#include "device/can_port.h"

namespace rubble::stabilizer {

/// A raw SocketCAN socket. It hears the frames of these nodes (all frames when there are none) and the
/// controller's error frames, each with the kernel's time of reception. Throws common::Error.
std::unique_ptr<CanPort> openSocketCan(const std::string& interface, std::span<const int> nodes);

}  // namespace rubble::stabilizer
