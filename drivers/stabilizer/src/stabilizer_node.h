#pragma once

#include <array>
#include <memory>
#include <string>

#include "device/stabilizer_driver.h"
#include "lcm_io/bus.h"
#include "lcm_io/node.h"
#include "lcm_io/process.h"

namespace rubble::stabilizer {

/// Hands STABILIZER_COMMAND to the driver, publishes what the plate does as STABILIZER, and says in HEALTH
/// how the drives are.
class StabilizerNode : public lcm_io::Node {
 public:
  /// `interface` is for HEALTH's words; `open` opens it.
  StabilizerNode(lcm_io::Bus& bus, const StabilizerDriver::Options& options, const std::string& interface,
                 OpenCanPort open);

  void advance(common::Utime now) override;
  lcm_io::NodeStatus status() const override;

 private:
  lcm_io::Bus& bus_;
  const std::string interface_;
  const std::array<int, 2> nodes_;
  StabilizerDriver driver_;  // Last: its thread ends first.
};

/// The node as section `stabilizer` says.
std::unique_ptr<lcm_io::Node> makeStabilizerNode(const lcm_io::ProcessContext& context);

}  // namespace rubble::stabilizer
