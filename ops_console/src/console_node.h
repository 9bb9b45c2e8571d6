#pragma once

#include <memory>
#include <rubble/health_t.hpp>

#include "async_writer.h"
#include "health_watch.h"
#include "lcm_io/bus.h"
#include "lcm_io/node.h"
#include "lcm_io/process.h"
#include "loss_counter.h"
#include "ops_console_config.h"

namespace rubble::ops_console {

/// The logging half of the console between the bus and the disk: logs every channel but those the table says
/// not to, counts what the bus lost, watches the HEALTH of all other processes.
class ConsoleNode : public lcm_io::Node {
 public:
  ConsoleNode(lcm_io::Bus& bus, std::unique_ptr<LogSink> sink, std::size_t queue_bytes);

  void finish() override { writer_.finish(); }
  lcm_io::NodeStatus status() const override;

 private:
  void onMessage(const lcm_io::RawMessage& message);
  void onHealth(const rubble::health_t& health);

  lcm_io::Bus& bus_;
  AsyncWriter writer_;
  LossCounter losses_;
  HealthWatch watch_;
  common::Utime last_loss_utime_ = 0;
};

/// The node with its logs on the disk, as section `ops_console` says.
std::unique_ptr<lcm_io::Node> makeConsoleNode(const lcm_io::ProcessContext& context);

}  // namespace rubble::ops_console
