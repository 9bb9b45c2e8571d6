#pragma once

#include <atomic>
#include <condition_variable>
#include <deque>
#include <functional>
#include <lcm/lcm-cpp.hpp>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "lcm_io/bus.h"

namespace rubble::lcm_io {

/// LCM's default multicast group with the receive buffer that 200 kB messages need.
inline constexpr char kDefaultLcmUrl[] = "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=4194304";

/// The live bus: udpm:// or memq://. One thread drains LCM into a queue that holds
/// ChannelInfo::queue_capacity messages of every channel and 64 MB in all; a full queue drops the channel's
/// oldest and counts it.
class LcmBus : public Bus {
 public:
  /// `process` is the publisher's name in the channel table: publishing on its channels stops when
  /// another process is heard there. Throws Error when LCM does not take the URL.
  LcmBus(const std::string& url, std::string process);
  ~LcmBus() override;

  bool dispatch(std::chrono::milliseconds timeout) override;
  void wake() override;
  bool ended() const override { return false; }
  common::Utime now() const override;
  std::string conflict() const override;

  /// Takes what has already arrived at this host (and comes within 50 ms), then nothing more; dispatch()
  /// hands out the rest.
  void stopReceiving() override;

 private:
  struct OwnChannel {
    std::vector<std::uint64_t> sent;  // Hashes of what we sent and have not heard back, oldest first.
    bool foreign = false;
  };

  void attach(const std::string& channel) override;
  bool send(const std::string& channel, ByteView data) override;
  void receive();
  void listen(const std::string& channel);
  void onMessage(const lcm_recv_buf_t& buffer, std::string_view channel);
  void compareWithSent(OwnChannel& own, std::uint64_t hash);
  void enqueue(RawMessage message);
  void dropOldest(const std::string& channel);

  const std::string process_;
  lcm::LCM lcm_;
  std::set<std::string> listening_;  // What LCM has been asked for.

  mutable std::mutex mutex_;
  std::condition_variable arrived_;
  std::deque<RawMessage> inbox_;
  std::size_t inbox_bytes_ = 0;
  std::map<std::string, std::size_t> inbox_count_;
  ChannelStatsMap inbox_stats_;
  std::map<std::string, OwnChannel, std::less<>> own_;
  std::set<std::string, std::less<>> wanted_;  // What dispatch() shall hand out.
  bool woken_ = false;
  std::atomic<bool> stopping_ = false;
  common::Utime stop_utime_ = 0;    // Written before stopping_.
  common::Utime newest_utime_ = 0;  // Receive time of the newest message; the receiver's own.
  std::thread receiver_;
};

}  // namespace rubble::lcm_io
