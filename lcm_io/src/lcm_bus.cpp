#include "lcm_io/lcm_bus.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <string_view>

#include "common/error.h"
#include "lcm_io/channels.h"
#include "lcm_io/host_checks.h"

namespace rubble::lcm_io {

namespace {

constexpr std::size_t kInboxBytes = 64 << 20;
constexpr std::size_t kUnlistedCapacity = 1000;
constexpr int kLcmQueue = 4096;
constexpr std::size_t kRememberedHashes = kLcmQueue;
constexpr int kReceiveTimeoutMs = 50;
constexpr std::chrono::seconds kLongestDrain{2};

common::Utime clockNow() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

/// Why LCM does not take the URL, as far as the host explains it.
std::string explainRefusal(const std::string& url) {
  for (const HostCheck& check : checkHost(url)) {
    if (!check.ok && check.fatal) {
      return check.text;
    }
  }
  return fmt::format("the default is {}", kDefaultLcmUrl);
}

std::uint64_t hashOf(ByteView data) {
  return std::hash<std::string_view>{}({reinterpret_cast<const char*>(data.data()), data.size()});
}

}  // namespace

LcmBus::LcmBus(const std::string& url, std::string process) : process_(std::move(process)), lcm_(url) {
  if (url.starts_with("file://")) {
    throw common::Error(fmt::format("--lcm-url {}: a log is no live bus", url));
  }
  // The file descriptor needs the receiving socket, so that nothing is missed from here on.
  if (!lcm_.good() || lcm_.getFileno() < 0) {
    throw common::Error(fmt::format("--lcm-url {}: LCM cannot open it; {}", url, explainRefusal(url)));
  }
  receiver_ = std::thread([this] { receive(); });
}

LcmBus::~LcmBus() { stopReceiving(); }

void LcmBus::stopReceiving() {
  if (!stopping_) {
    stop_utime_ = clockNow();
    stopping_ = true;
  }
  if (receiver_.joinable()) {
    receiver_.join();
  }
}

void LcmBus::receive() {
  while (!stopping_) {
    lcm_.handleTimeout(kReceiveTimeoutMs);
  }
  // What this host already holds still counts; steady traffic must not keep us here. The margin is for
  // messages between kernel and LCM, the deadline for a clock that is set back.
  const common::Utime last_utime = stop_utime_ + 1000 * kReceiveTimeoutMs;
  const auto deadline = std::chrono::steady_clock::now() + kLongestDrain;
  while (lcm_.handleTimeout(kReceiveTimeoutMs) > 0 && newest_utime_ <= last_utime &&
         std::chrono::steady_clock::now() < deadline) {
  }
}

void LcmBus::attach(const std::string& channel) {
  {
    const std::lock_guard lock(mutex_);
    wanted_.insert(channel);
  }
  listen(channel);
}

void LcmBus::listen(const std::string& channel) {
  // Two LCM subscriptions that match one channel would bring every message twice.
  RUBBLE_CHECK(channel != kEveryChannel || listening_.empty());
  if (listening_.contains(kEveryChannel) || !listening_.insert(channel).second) {
    return;
  }
  lcm_subscription_t* subscription = lcm_subscribe(
      lcm_.getUnderlyingLCM(), channel.c_str(),
      [](const lcm_recv_buf_t* buffer, const char* name, void* self) {
        static_cast<LcmBus*>(self)->onMessage(*buffer, name);
      },
      this);
  RUBBLE_CHECK(subscription != nullptr);
  lcm_subscription_set_queue_capacity(subscription, kLcmQueue);
}

bool LcmBus::send(const std::string& channel, ByteView data) {
  const ChannelInfo* info = findChannel(channel);
  if (info != nullptr && info->publisher == process_) {
    listen(channel);
    const std::lock_guard lock(mutex_);
    OwnChannel& own = own_[channel];
    if (own.foreign) {
      return false;
    }
    if (own.sent.size() == kRememberedHashes) {
      own.sent.erase(own.sent.begin());
    }
    own.sent.push_back(hashOf(data));
  }
  return lcm_.publish(channel, data.data(), static_cast<unsigned int>(data.size())) == 0;
}

void LcmBus::compareWithSent(OwnChannel& own, std::uint64_t hash) {
  const auto found = std::find(own.sent.begin(), own.sent.end(), hash);
  if (found == own.sent.end()) {
    own.foreign = true;
  } else {
    own.sent.erase(found);
  }
}

void LcmBus::onMessage(const lcm_recv_buf_t& buffer, std::string_view channel) {
  const ByteView data(static_cast<const std::uint8_t*>(buffer.data), buffer.data_size);
  newest_utime_ = buffer.recv_utime;
  const std::lock_guard lock(mutex_);
  if (const auto own = own_.find(channel); own != own_.end()) {
    compareWithSent(own->second, hashOf(data));
  }
  // Only what is wanted is copied: most of what a publisher hears is its own.
  if (wanted_.contains(channel) || wanted_.contains(kEveryChannel)) {
    enqueue({std::string(channel), buffer.recv_utime, Bytes(data.begin(), data.end())});
    arrived_.notify_one();
  }
}

void LcmBus::dropOldest(const std::string& channel) {
  const auto oldest =
      std::find_if(inbox_.begin(), inbox_.end(), [&](const RawMessage& m) { return m.channel == channel; });
  RUBBLE_CHECK(oldest != inbox_.end());
  inbox_bytes_ -= oldest->data.size();
  --inbox_count_[channel];
  ++inbox_stats_[channel].dropped;
  inbox_.erase(oldest);
}

void LcmBus::enqueue(RawMessage message) {
  const ChannelInfo* info = findChannel(message.channel);
  // A listener to everything (the console) is bounded by bytes alone.
  const std::size_t capacity =
      wanted_.contains(kEveryChannel) || info == nullptr ? kUnlistedCapacity * 100 : info->queue_capacity;
  while (inbox_count_[message.channel] >= capacity) {
    dropOldest(message.channel);
  }
  while (!inbox_.empty() && inbox_bytes_ + message.data.size() > kInboxBytes) {
    dropOldest(std::string(inbox_.front().channel));
  }
  inbox_bytes_ += message.data.size();
  ++inbox_count_[message.channel];
  inbox_.push_back(std::move(message));
}

bool LcmBus::dispatch(std::chrono::milliseconds timeout) {
  std::unique_lock lock(mutex_);
  arrived_.wait_for(lock, timeout, [this] { return !inbox_.empty() || woken_; });
  woken_ = false;
  for (const auto& [channel, stats] : inbox_stats_) {
    noteDropped(channel, stats.dropped);
  }
  if (inbox_.empty()) {
    return false;
  }
  const RawMessage message = std::move(inbox_.front());
  inbox_.pop_front();
  inbox_bytes_ -= message.data.size();
  --inbox_count_[message.channel];
  lock.unlock();
  deliver(message);
  return true;
}

void LcmBus::wake() {
  const std::lock_guard lock(mutex_);
  woken_ = true;
  arrived_.notify_one();
}

common::Utime LcmBus::now() const { return clockNow(); }

std::string LcmBus::conflict() const {
  const std::lock_guard lock(mutex_);
  for (const auto& [channel, own] : own_) {
    if (own.foreign) {
      return channel;
    }
  }
  return {};
}

}  // namespace rubble::lcm_io
