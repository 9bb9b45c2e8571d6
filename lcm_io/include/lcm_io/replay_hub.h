#pragma once

#include <deque>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "lcm_io/bus.h"

namespace rubble::lcm_io {

/// A bus inside one thread, for replay and tests: what is fed or published reaches every endpoint in
/// the order it came, at the hub's time. No clock, no thread: two runs are identical.
class ReplayHub {
 public:
  ReplayHub();
  ~ReplayHub();

  /// One process's bus; lives as long as the hub.
  Bus& endpoint();

  /// Lets time pass; it never goes back.
  void advanceTo(common::Utime utime);
  /// Advances to the message's receive_utime and delivers it, then all that is published meanwhile.
  void feed(const RawMessage& message);
  /// Delivers what was published outside a handler.
  void deliverPending();

  common::Utime now() const { return now_; }

 private:
  class Endpoint;

  common::Utime now_ = 0;
  std::deque<RawMessage> pending_;
  std::vector<std::unique_ptr<Endpoint>> endpoints_;
};

}  // namespace rubble::lcm_io
