#include "lcm_io/replay_hub.h"

#include <algorithm>

namespace rubble::lcm_io {

class ReplayHub::Endpoint : public Bus {
 public:
  explicit Endpoint(ReplayHub& hub) : hub_(hub) {}

  bool dispatch(std::chrono::milliseconds /*timeout*/) override { return false; }
  bool ended() const override { return true; }
  common::Utime now() const override { return hub_.now_; }

  void take(const RawMessage& message) {
    if (channels_.contains(message.channel) || channels_.contains(kEveryChannel)) {
      deliver(message);
    }
  }

 private:
  void attach(const std::string& channel) override { channels_.insert(channel); }
  bool send(const std::string& channel, ByteView data) override {
    hub_.pending_.push_back({channel, hub_.now_, Bytes(data.begin(), data.end())});
    return true;
  }

  ReplayHub& hub_;
  std::set<std::string> channels_;
};

ReplayHub::ReplayHub() = default;
ReplayHub::~ReplayHub() = default;

Bus& ReplayHub::endpoint() { return *endpoints_.emplace_back(std::make_unique<Endpoint>(*this)); }

void ReplayHub::advanceTo(common::Utime utime) { now_ = std::max(now_, utime); }

void ReplayHub::feed(const RawMessage& message) {
  advanceTo(message.receive_utime);
  pending_.push_back(message);
  deliverPending();
}

void ReplayHub::deliverPending() {
  while (!pending_.empty()) {
    const RawMessage next = std::move(pending_.front());
    pending_.pop_front();
    for (const auto& endpoint : endpoints_) {
      endpoint->take(next);
    }
  }
}

}  // namespace rubble::lcm_io
