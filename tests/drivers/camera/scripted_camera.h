#pragma once

#include <linux/videodev2.h>

#include <atomic>
#include <condition_variable>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "system_calls.h"

namespace rubble::camera {

/// The kernel with one camera in it, on a clock of its own that only wait() moves. What a test changes must
/// be changed before another thread uses it.
class ScriptedCamera : public SystemCalls {
 public:
  /// One picture, or what comes instead of it.
  struct Event {
    /// DQBUF's answer; 0 is a picture.
    int error = 0;
    bool silent = false;
    std::uint32_t flags = 0;
    /// What its stamp says less than the monotonic clock, ns.
    std::int64_t clock_error = 0;
    /// Numbers left out before it.
    std::uint32_t gap = 0;
    /// Of the content; -1 all.
    int bytes = -1;
  };

  static constexpr std::int64_t kEpoch = 1'700'000'000'000'000'000;  // ns, of the clock's zero
  static constexpr std::int64_t kPeriod = 40'000'000;                // ns
  /// From the stamp to the moment the picture can be fetched, ns.
  static constexpr std::int64_t kTransfer = 3'000'000;

  int open(const std::string& path) override;
  void close(int fd) override;
  int control(int fd, unsigned long request, void* argument) override;
  void* map(int fd, std::size_t size, std::int64_t offset) override;
  void unmap(void* memory, std::size_t size) override;
  Wait wait(int fd, std::chrono::milliseconds timeout) override;
  void wake() override;
  ClockReading readClocks() override { return {time, kEpoch + time, time}; }

  /// Files and memory that are in use now.
  int inUse() const { return open_files_ + static_cast<int>(mapped_.size()); }

  std::int64_t time = 1'000'000'000;  // ns, monotonic
  bool present = true;
  std::vector<std::uint32_t> formats{V4L2_PIX_FMT_MJPEG, V4L2_PIX_FMT_YUYV, V4L2_PIX_FMT_GREY};
  /// What the driver makes of the format that was asked for.
  std::function<void(v4l2_pix_format&)> change = [](v4l2_pix_format&) {};
  double rate = 25.0;
  std::map<std::uint32_t, std::int32_t> controls;
  /// Of every control: a larger wish becomes this.
  std::int32_t largest_control = 10'000;
  /// Answers of requests (VIDIOC_...) instead of their work, until they are erased.
  std::map<unsigned long, int> refusals;
  std::deque<Event> events;
  /// The content of every picture.
  std::vector<std::uint8_t> content;
  /// Pictures after the events: then the camera is silent, or where `blocks`, wait() waits for wake().
  int pictures = 1'000'000;
  bool blocks = false;

  std::vector<std::chrono::milliseconds> pauses;
  int opened = 0;

 private:
  int dequeue(v4l2_buffer& buffer);

  int open_files_ = 0;
  std::map<std::uint32_t, std::vector<std::uint8_t>> memory_;
  std::set<void*> mapped_;
  std::vector<std::uint32_t> queued_;  // Oldest first.
  std::uint32_t sequence_ = 0;
  Event next_;

  std::mutex mutex_;
  std::condition_variable woken_;
  bool wake_ = false;
};

}  // namespace rubble::camera
