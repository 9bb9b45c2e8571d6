#pragma once

#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "exposure_time.h"
#include "picture_maker.h"
#include "picture_queue.h"
#include "sequence_counter.h"
#include "video_device.h"

namespace rubble::camera {

/// How the capture is; HEALTH carries it.
struct CaptureStatus {
  /// One of device_state.
  std::string state = device_state::kStarting;
  /// What is wrong and how to fix it; while pictures flow, also what was wrong in the last seconds.
  std::string detail;
  std::map<std::string, std::int64_t> counters;
};

/// Keeps a camera delivering: opens it, fills the queue, and after any fault opens it anew, with pauses that
/// grow from 0.1 to 2 s until pictures come. No thread inside: step() is called in a loop by one.
class Capture {
 public:
  /// `arrived` is called after each push to the queue.
  Capture(SystemCalls& calls, CameraSetup setup, PictureQueue& queue, std::function<void()> arrived);

  /// Opens the device, or handles one picture, or waits: at most CameraConfig::silence.
  void step();

  /// Any thread.
  CaptureStatus status() const;

 private:
  void open();
  void takePicture();
  /// False when it is damaged.
  bool accept(const Frame& frame);
  /// `time`: of its arrival.
  void stampPicture(const Frame& frame, std::int64_t time, bot_core::image_t& picture);
  /// Drops the device and pauses.
  void fail(const DeviceError& error);
  std::int64_t now() { return calls_.readClocks().monotonic_before; }

  SystemCalls& calls_;
  const CameraSetup setup_;
  PictureQueue& queue_;
  const std::function<void()> arrived_;

  // The thread of step() alone. Times are ns of the monotonic clock.
  std::unique_ptr<VideoDevice> device_;
  std::unique_ptr<PictureMaker> maker_;
  SequenceCounter sequence_;
  std::string exposure_us_;
  std::chrono::milliseconds pause_;
  std::int64_t last_good_ = 0;

  /// Something that happened, how often, and when last.
  struct Events {
    std::int64_t count = 0;
    std::int64_t last = 0;

    void add(std::int64_t events, std::int64_t time) {
      count += events;
      last = events > 0 ? time : last;
    }
    bool areNews(std::int64_t time) const;
  };

  mutable std::mutex mutex_;
  std::string state_ = device_state::kStarting;
  /// The last one's sentence.
  std::string fault_;
  std::vector<std::string> complaints_;
  std::int64_t latest_ = 0;
  std::int64_t opened_ = 0;
  Events faults_;
  Events missing_;
  Events damaged_;
  Events unstamped_;
};

}  // namespace rubble::camera
