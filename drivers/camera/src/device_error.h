#pragma once

#include <string>

#include "common/error.h"

namespace rubble::camera {

/// Why the camera gives no pictures: a word for HEALTH's state, and a sentence that names device and fix.
class DeviceError : public common::Error {
 public:
  DeviceError(std::string state, const std::string& sentence)
      : common::Error(sentence), state_(std::move(state)) {}

  const std::string& state() const { return state_; }

 private:
  std::string state_;
};

namespace device_state {
/// Not there, or gone while it was used.
inline constexpr char kNoDevice[] = "no_device";
/// There, but it or the kernel refuses what the configuration needs.
inline constexpr char kRefused[] = "refused";
/// Open, but without good pictures.
inline constexpr char kSilent[] = "silent";
inline constexpr char kStarting[] = "starting";
inline constexpr char kStreaming[] = "streaming";
}  // namespace device_state

}  // namespace rubble::camera
