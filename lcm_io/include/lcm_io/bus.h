#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <string>
#include <utility>

#include "common/time.h"
#include "lcm_io/codec.h"

namespace rubble::lcm_io {

/// What a process knows of one channel since its start; HEALTH carries it.
struct ChannelStats {
  std::int64_t count = 0;
  std::int64_t dropped = 0;
  std::int64_t errors = 0;
  std::string last_error;
  // From a message's utime to its handling, over the current report interval.
  std::int64_t latency_count = 0;
  double latency_sum_ms = 0.0;
  double latency_max_ms = 0.0;
};

using ChannelStatsMap = std::map<std::string, ChannelStats>;

/// A message as it came from the bus.
struct RawMessage {
  std::string channel;
  common::Utime receive_utime = 0;
  Bytes data;
};

/// One process's end of the bus. Live it stands on LCM (LcmBus) or a log (LogBus), in replay and tests on a
/// ReplayHub; the process cannot tell. Not thread-safe: handlers run inside dispatch(), on the thread that
/// owns the bus.
class Bus {
 public:
  using RawHandler = std::function<void(const RawMessage&)>;

  virtual ~Bus() = default;
  Bus() = default;
  Bus(const Bus&) = delete;
  Bus& operator=(const Bus&) = delete;

  /// One handler per channel. A message of another type, a damaged one, or one whose handler throws
  /// Error is counted against the channel, and the process lives.
  template <typename Message>
  void subscribe(const std::string& channel, std::function<void(const Message&)> handler) {
    subscribeRaw(channel, [this, handler = std::move(handler)](const RawMessage& raw) {
      const Message message = decode<Message>(raw.data);
      if constexpr (requires { message.utime; }) {
        noteLatency(raw.channel, message.utime);
      }
      handler(message);
    });
  }
  void subscribeRaw(const std::string& channel, RawHandler handler);
  /// Every channel without a handler of its own.
  void subscribeAll(RawHandler handler);

  /// Allocates nothing once messages of this size have been published (channel names beyond 15 characters
  /// aside).
  template <typename Message>
  void publish(const std::string& channel, const Message& message) {
    encodeInto(message, encoded_);
    publishRaw(channel, encoded_);
  }
  void publishRaw(const std::string& channel, ByteView data);

  /// Handles one message. False when none came within the time or none can come any more (ended()).
  virtual bool dispatch(std::chrono::milliseconds timeout) = 0;
  /// Ends a dispatch() that waits, or the next one that would: a node's own thread has something for it. The
  /// only call that any thread may make.
  virtual void wake() {}
  /// Takes what has already arrived, then nothing more; dispatch() hands out the rest.
  virtual void stopReceiving() {}
  /// True once the log behind the bus is played to its end; never live.
  virtual bool ended() const = 0;
  /// The bus's time: the clock live, the log's time in replay.
  virtual common::Utime now() const = 0;

  /// A channel that another process publishes although it is this one's, and which is therefore no
  /// longer published here; empty when all is well.
  virtual std::string conflict() const { return {}; }

  const ChannelStatsMap& received() const { return received_; }
  const ChannelStatsMap& published() const { return published_; }
  void resetLatency();
  /// Counts a message as refused that was found bad only after its handler had returned.
  void refuse(const std::string& channel, const std::string& why);

 protected:
  /// Makes a channel's messages (`kEveryChannel`: all) arrive at dispatch().
  virtual void attach(const std::string& channel) = 0;
  /// The data is the caller's. False when the message was held back.
  virtual bool send(const std::string& channel, ByteView data) = 0;

  void deliver(const RawMessage& message);
  void noteDropped(const std::string& channel, std::int64_t dropped) { received_[channel].dropped = dropped; }

  static constexpr char kEveryChannel[] = ".*";

 private:
  void noteLatency(const std::string& channel, common::Utime utime);

  std::map<std::string, RawHandler> handlers_;
  RawHandler all_handler_;
  ChannelStatsMap received_;
  ChannelStatsMap published_;
  Bytes encoded_;  // Of the message that is being published.
};

}  // namespace rubble::lcm_io
