#pragma once

#include <string>

#include "lcm_io/node.h"

namespace rubble::lcm_io {

/// A process of the graph whose work is not written yet: it starts, stops and says so in HEALTH.
class PlaceholderNode : public Node {
 public:
  explicit PlaceholderNode(std::string missing) : missing_(std::move(missing)) {}

  NodeStatus status() const override { return {NodeStatus::Level::kDegraded, "no_algorithm", missing_, {}}; }

 private:
  std::string missing_;
};

}  // namespace rubble::lcm_io
