#include "protocol/drive_setup.h"

#include <array>
#include <span>

#include "protocol/canopen.h"

namespace rubble::stabilizer {

namespace {

constexpr std::uint32_t kPdoOff = 0x80000000U;  // Bit 31 of a PDO's COB-ID.
constexpr std::uint32_t kEverySync = 1;         // Transmission type.

/// Index, subindex and length in bits of a mapped object.
constexpr std::uint32_t mapped(std::uint16_t index, std::uint8_t bits) {
  return static_cast<std::uint32_t>(index) << 16 | bits;
}

/// `parameter`: 0x1400 or 0x1800; its mapping is 0x200 further.
void addPdo(std::vector<SetupStep>& steps, std::uint16_t parameter, std::uint32_t cob_id,
            std::span<const std::uint32_t> objects) {
  const auto mapping = static_cast<std::uint16_t>(parameter + 0x200);
  steps.push_back({{parameter, 1}, cob_id | kPdoOff, 4});
  steps.push_back({{parameter, 2}, kEverySync, 1});
  steps.push_back({{mapping, 0}, 0, 1});
  std::uint8_t subindex = 0;
  for (const std::uint32_t object : objects) {
    steps.push_back({{mapping, ++subindex}, object, 4});
  }
  steps.push_back({{mapping, 0}, subindex, 1});
  steps.push_back({{parameter, 1}, cob_id, 4});
}

}  // namespace

std::vector<SetupStep> setupSteps(const DriveSetup& setup) {
  std::vector<SetupStep> steps = {{kDeviceType}, {kSupportedModes}};
  steps.push_back({{0x1017, 0}, static_cast<std::uint32_t>(setup.heartbeat_ms), 2});
  const auto node = static_cast<std::uint32_t>(setup.node);
  addPdo(steps, 0x1400, cob::kSetPoint + node, std::array{mapped(0x6040, 16), mapped(0x607A, 32)});
  addPdo(steps, 0x1800, cob::kStatus + node, std::array{mapped(0x6041, 16), mapped(0x6064, 32)});
  steps.push_back({{0x6060, 0}, static_cast<std::uint32_t>(setup.mode), 1});
  if (setup.mode == Mode::kCyclicSynchronousPosition) {
    // The time between two set-points: so many units of 10^-3 s.
    steps.push_back({{0x60C2, 1}, static_cast<std::uint32_t>(setup.cycle_ms), 1});
    steps.push_back({{0x60C2, 2}, static_cast<std::uint32_t>(-3), 1});
  } else {
    steps.push_back({{0x6081, 0}, setup.profile_velocity, 4});
    steps.push_back({{0x6083, 0}, setup.profile_acceleration, 4});
    steps.push_back({{0x6084, 0}, setup.profile_acceleration, 4});
  }
  // Quick stop: slow down on the quick stop ramp, then hold the position.
  steps.push_back({{0x605A, 0}, 6, 2});
  return steps;
}

}  // namespace rubble::stabilizer
