#pragma once

#include <bot_core/planar_lidar_t.hpp>
#include <memory>

#include "device/lidar_reader.h"
#include "lcm_io/bus.h"
#include "lcm_io/node.h"
#include "lcm_io/process.h"

namespace rubble::lidar {

/// Publishes what the reader brings as SCAN and says in HEALTH how the sensor is.
class LidarNode : public lcm_io::Node {
 public:
  LidarNode(lcm_io::Bus& bus, LidarReader::Options options);

  void advance(common::Utime now) override;
  lcm_io::NodeStatus status() const override;

 private:
  lcm_io::Bus& bus_;
  const std::string address_;
  LidarScan scan_;
  bot_core::planar_lidar_t message_;
  LidarReader reader_;  // Last: its thread ends first.
};

/// The node as section `lidar` says.
std::unique_ptr<lcm_io::Node> makeLidarNode(const lcm_io::ProcessContext& context);

}  // namespace rubble::lidar
