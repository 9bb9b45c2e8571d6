#include "capture.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace rubble::camera {

namespace {

constexpr std::int64_t kMillisecond = 1'000'000;
constexpr std::int64_t kNewsTime = 10'000 * kMillisecond;
constexpr std::chrono::milliseconds kShortestPause{100};
constexpr std::chrono::milliseconds kLongestPause{2000};
constexpr std::size_t kClockReadings = 3;

}  // namespace

bool Capture::Events::areNews(std::int64_t time) const { return count > 0 && time - last < kNewsTime; }

Capture::Capture(SystemCalls& calls, CameraSetup setup, PictureQueue& queue, std::function<void()> arrived)
    : calls_(calls),
      setup_(std::move(setup)),
      queue_(queue),
      arrived_(std::move(arrived)),
      pause_(kShortestPause) {}

void Capture::step() {
  try {
    if (device_ == nullptr) {
      open();
    } else {
      takePicture();
    }
  } catch (const DeviceError& error) {
    fail(error);
  }
}

void Capture::open() {
  device_ = std::make_unique<VideoDevice>(calls_, setup_);
  maker_ = std::make_unique<PictureMaker>(setup_.camera, device_->format());
  sequence_ = {};
  const double exposure = device_->controls().exposure;
  exposure_us_ = exposure > 0.0 ? fmt::format("{}", std::lround(exposure * 1e6)) : std::string();
  last_good_ = now();
  // Only a picture changes the state: a device that opens and stays silent is as silent as before.
  const std::lock_guard lock(mutex_);
  complaints_ = device_->controls().complaints;
  ++opened_;
}

void Capture::takePicture() {
  const auto silence = static_cast<std::int64_t>(setup_.camera.silence * 1000.0);
  const std::int64_t left = silence - (now() - last_good_) / kMillisecond;
  const auto frame = device_->next(std::chrono::milliseconds(std::clamp<std::int64_t>(left, 1, silence)));
  bool good = false;
  if (frame) {
    good = accept(*frame);
    device_->release(*frame);
  }
  if (!good && now() - last_good_ >= silence * kMillisecond) {
    throw DeviceError(
        device_state::kSilent,
        damaged_.last > last_good_
            ? fmt::format("{} has given only damaged pictures for {} s; use another USB port or cable",
                          setup_.camera.device, setup_.camera.silence)
            : fmt::format("{} has given no picture for {} s; check cable and power, or plug it in again",
                          setup_.camera.device, setup_.camera.silence));
  }
}

bool Capture::accept(const Frame& frame) {
  const std::int64_t time = now();
  PictureQueue::Picture picture = queue_.blank();
  const bool good = !frame.damaged && maker_->make(frame.bytes, *picture);
  if (good) {
    stampPicture(frame, time, *picture);
    queue_.push(std::move(picture));
    last_good_ = time;
    pause_ = kShortestPause;
  } else {
    queue_.giveBack(std::move(picture));
  }
  {
    const std::lock_guard lock(mutex_);
    latest_ = time;
    missing_.add(sequence_.missing(frame.sequence), time);
    damaged_.add(good ? 0 : 1, time);
    if (good) {
      state_ = device_state::kStreaming;
    }
  }
  if (good) {
    arrived_();
  }
  return good;
}

void Capture::stampPicture(const Frame& frame, std::int64_t time, bot_core::image_t& picture) {
  std::array<ClockReading, kClockReadings> readings;
  std::generate(readings.begin(), readings.end(), [this] { return calls_.readClocks(); });
  const bool stamped = isPlausible(frame.stamp.monotonic, time);
  if (!stamped) {
    const std::lock_guard lock(mutex_);
    unstamped_.add(1, time);
  }
  picture.utime = midExposure(stamped ? frame.stamp : BufferStamp{time, false}, device_->controls().exposure,
                              setup_.camera.stamp_delay, clockOffset(readings));
  picture.nmetadata = exposure_us_.empty() ? 0 : 1;
  picture.metadata.resize(static_cast<std::size_t>(picture.nmetadata));
  if (!exposure_us_.empty()) {
    bot_core::image_metadata_t& exposure = picture.metadata[0];
    exposure.key = "exposure_us";
    exposure.value.assign(exposure_us_.begin(), exposure_us_.end());
    exposure.n = static_cast<std::int32_t>(exposure.value.size());
  }
}

void Capture::fail(const DeviceError& error) {
  device_.reset();
  {
    const std::lock_guard lock(mutex_);
    state_ = error.state();
    fault_ = error.what();
    faults_.add(1, now());
  }
  calls_.wait(-1, pause_);
  pause_ = std::min(2 * pause_, kLongestPause);
}

CaptureStatus Capture::status() const {
  const std::int64_t dropped = queue_.dropped();
  const std::lock_guard lock(mutex_);
  CaptureStatus status{state_,
                       {},
                       {{"opened", opened_},
                        {"faults", faults_.count},
                        {"missing", missing_.count},
                        {"damaged", damaged_.count},
                        {"dropped", dropped},
                        {"stamped_on_arrival", unstamped_.count}}};
  if (state_ == device_state::kStarting) {
    status.detail = fmt::format("{} has given no picture yet", setup_.camera.device);
  } else if (state_ != device_state::kStreaming) {
    status.detail = fault_;
  } else {
    const auto say = [&](const std::string& sentence) {
      status.detail += (status.detail.empty() ? "" : "; ") + sentence;
    };
    std::for_each(complaints_.begin(), complaints_.end(), say);
    if (faults_.areNews(latest_)) {
      say("back after: " + fault_);
    }
    if (missing_.areNews(latest_)) {
      say(setup_.camera.device +
          " leaves out pictures; use a USB port of its own, or a smaller format or rate");
    }
    if (damaged_.areNews(latest_)) {
      say(setup_.camera.device + " gives damaged pictures; use another USB port or cable");
    }
    if (unstamped_.areNews(latest_)) {
      say(setup_.camera.device + " gives no usable stamps: pictures carry the time of their arrival");
    }
  }
  return status;
}

}  // namespace rubble::camera
