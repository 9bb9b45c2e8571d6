#include "scripted_camera.h"

#include <algorithm>
#include <cerrno>

#include "common/error.h"

namespace rubble::camera {

namespace {

constexpr int kFile = 7;
constexpr std::uint32_t kBufferBytes = 1'000'000;
constexpr std::uint32_t kPage = 4096;

}  // namespace

int ScriptedCamera::open(const std::string& /*path*/) {
  if (!present) {
    return -ENOENT;
  }
  ++opened;
  ++open_files_;
  queued_.clear();
  return kFile;
}

void ScriptedCamera::close(int fd) {
  RUBBLE_CHECK(fd == kFile && open_files_ == 1);
  --open_files_;
}

int ScriptedCamera::control(int fd, unsigned long request, void* argument) {
  RUBBLE_CHECK(fd == kFile && open_files_ == 1);
  if (!present) {
    return -ENODEV;
  }
  if (const auto refusal = refusals.find(request); refusal != refusals.end()) {
    return refusal->second;
  }
  switch (request) {
    case VIDIOC_QUERYCAP:
      static_cast<v4l2_capability*>(argument)->capabilities = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
      return 0;
    case VIDIOC_ENUM_FMT: {
      auto& description = *static_cast<v4l2_fmtdesc*>(argument);
      if (description.index >= formats.size()) {
        return -EINVAL;
      }
      description.pixelformat = formats[description.index];
      return 0;
    }
    case VIDIOC_S_FMT: {
      v4l2_pix_format& pixels = static_cast<v4l2_format*>(argument)->fmt.pix;
      const bool jpeg = pixels.pixelformat == V4L2_PIX_FMT_MJPEG;
      pixels.bytesperline = jpeg ? 0 : pixels.width * (pixels.pixelformat == V4L2_PIX_FMT_YUYV ? 2 : 1);
      change(pixels);
      return 0;
    }
    case VIDIOC_S_PARM:
      static_cast<v4l2_streamparm*>(argument)->parm.capture.timeperframe = {
          1000, static_cast<std::uint32_t>(1000.0 * rate)};
      return 0;
    case VIDIOC_S_CTRL: {
      const auto& wish = *static_cast<v4l2_control*>(argument);
      return controls.contains(wish.id) ? (controls[wish.id] = std::min(wish.value, largest_control), 0)
                                        : -EINVAL;
    }
    case VIDIOC_G_CTRL: {
      auto& wish = *static_cast<v4l2_control*>(argument);
      return controls.contains(wish.id) ? (wish.value = controls[wish.id], 0) : -EINVAL;
    }
    case VIDIOC_QUERYCTRL: {
      auto& range = *static_cast<v4l2_queryctrl*>(argument);
      range.minimum = 0;
      range.maximum = largest_control;
      range.step = 1;
      return 0;
    }
    case VIDIOC_REQBUFS:
    case VIDIOC_STREAMON:
    case VIDIOC_STREAMOFF:
      return 0;
    case VIDIOC_QUERYBUF: {
      auto& buffer = *static_cast<v4l2_buffer*>(argument);
      buffer.length = kBufferBytes;
      buffer.m.offset = buffer.index * kPage;
      return 0;
    }
    case VIDIOC_QBUF:
      queued_.push_back(static_cast<v4l2_buffer*>(argument)->index);
      return 0;
    case VIDIOC_DQBUF:
      return dequeue(*static_cast<v4l2_buffer*>(argument));
    default:
      return -ENOTTY;
  }
}

int ScriptedCamera::dequeue(v4l2_buffer& buffer) {
  if (next_.error != 0) {
    return next_.error;
  }
  sequence_ += 1 + next_.gap;
  buffer.index = queued_.front();
  queued_.erase(queued_.begin());
  buffer.sequence = sequence_;
  buffer.flags = next_.flags;
  const std::int64_t stamp = time - kTransfer - next_.clock_error;
  buffer.timestamp = {stamp / 1'000'000'000, stamp % 1'000'000'000 / 1000};
  const std::size_t bytes = next_.bytes >= 0 ? static_cast<std::size_t>(next_.bytes)
                                             : std::min<std::size_t>(content.size(), kBufferBytes);
  std::copy_n(content.begin(), bytes, memory_[buffer.index].begin());
  buffer.bytesused = static_cast<std::uint32_t>(bytes);
  return 0;
}

void* ScriptedCamera::map(int /*fd*/, std::size_t size, std::int64_t offset) {
  auto& memory = memory_[static_cast<std::uint32_t>(offset) / kPage];
  memory.resize(size);
  mapped_.insert(memory.data());
  return memory.data();
}

void ScriptedCamera::unmap(void* memory, std::size_t size) {
  RUBBLE_CHECK(size == kBufferBytes && mapped_.erase(memory) == 1);
}

SystemCalls::Wait ScriptedCamera::wait(int fd, std::chrono::milliseconds timeout) {
  const std::int64_t end = time + timeout.count() * 1'000'000;
  if (fd < 0) {
    pauses.push_back(timeout);
    time = end;
    return Wait::kTimeout;
  }
  const bool exhausted = events.empty() && pictures == 0;
  if (exhausted && blocks) {
    std::unique_lock lock(mutex_);
    woken_.wait(lock, [this] { return wake_; });
    return Wait::kWoken;
  }
  next_ = {};
  if (!events.empty()) {
    next_ = events.front();
    events.pop_front();
  } else if (!exhausted) {
    --pictures;
  }
  // Without a free buffer no picture comes.
  if (exhausted || next_.silent || (next_.error == 0 && queued_.empty())) {
    time = end;
    return Wait::kTimeout;
  }
  time += kPeriod;
  return Wait::kReady;
}

void ScriptedCamera::wake() {
  const std::lock_guard lock(mutex_);
  wake_ = true;
  woken_.notify_all();
}

}  // namespace rubble::camera
