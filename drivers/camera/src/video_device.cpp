#include "video_device.h"

#include <fmt/format.h>
#include <linux/videodev2.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace rubble::camera {

namespace {

/// One is filled, one is read, two wait for their turn.
constexpr std::uint32_t kBuffers = 4;

std::string adviceFor(int error) {
  switch (error) {
    case EBUSY:
      return "another program uses it: `fuser -v` names it";
    case EACCES:
    case EPERM:
      return "this user may not: add it to the group `video`";
    case EIO:
    case EPIPE:
    case EPROTO:
      return "check cable, hub and power if it happens again";
    default:
      return "see `dmesg`";
  }
}

v4l2_buffer captureBuffer(std::uint32_t index) {
  v4l2_buffer buffer{};
  buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  buffer.memory = V4L2_MEMORY_MMAP;
  buffer.index = index;
  return buffer;
}

}  // namespace

VideoDevice::VideoDevice(SystemCalls& calls, const CameraSetup& setup)
    : calls_(calls), setup_(setup), name_(setup.camera.device) {
  try {
    start();
  } catch (const DeviceError&) {
    close();
    throw;
  } catch (const common::Error& e) {
    close();
    throw DeviceError(device_state::kRefused, fmt::format("{} {}", name_, e.what()));
  }
}

VideoDevice::~VideoDevice() { close(); }

void VideoDevice::start() {
  fd_ = calls_.open(name_);
  demand(fd_, "be opened");
  checkCapabilities();
  chooseFormat();
  controls_ = applyControls(calls_, fd_, setup_);
  mapBuffers();
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  demand(calls_.control(fd_, VIDIOC_STREAMON, &type), "start streaming");
}

void VideoDevice::close() {
  if (fd_ < 0) {
    return;
  }
  // Whatever still works, works; a device that is gone refuses all of it.
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  calls_.control(fd_, VIDIOC_STREAMOFF, &type);
  for (const Memory& memory : buffers_) {
    calls_.unmap(memory.start, memory.size);
  }
  calls_.close(fd_);
}

int VideoDevice::demand(int result, const char* what) {
  if (result >= 0) {
    return result;
  }
  if (result == -ENOENT || result == -ENODEV || result == -ENXIO) {
    throw DeviceError(device_state::kNoDevice,
                      fmt::format("{} is not there; plug the camera in, or set camera.device to one that `ls "
                                  "/dev/v4l/by-path/` shows",
                                  name_));
  }
  throw DeviceError(device_state::kRefused, fmt::format("{} cannot {}: {}; {}", name_, what,
                                                        std::strerror(-result), adviceFor(-result)));
}

void VideoDevice::refuse(const std::string& what) const {
  throw DeviceError(device_state::kRefused, fmt::format("{} {}", name_, what));
}

void VideoDevice::checkCapabilities() {
  v4l2_capability capability{};
  if (calls_.control(fd_, VIDIOC_QUERYCAP, &capability) == -ENOTTY) {
    refuse("is no V4L2 device; set camera.device to one that `v4l2-ctl --list-devices` shows");
  }
  const std::uint32_t can = (capability.capabilities & V4L2_CAP_DEVICE_CAPS) != 0 ? capability.device_caps
                                                                                  : capability.capabilities;
  constexpr std::uint32_t kNeeded = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
  if ((can & kNeeded) != kNeeded) {
    refuse("does not stream pictures; a camera often has several nodes: set camera.device to its first");
  }
}

std::vector<std::int32_t> VideoDevice::offeredFormats() {
  std::vector<std::int32_t> offered;
  v4l2_fmtdesc description{};
  description.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  while (calls_.control(fd_, VIDIOC_ENUM_FMT, &description) >= 0) {
    offered.push_back(static_cast<std::int32_t>(description.pixelformat));
    ++description.index;
  }
  return offered;
}

FrameFormat VideoDevice::trySetting(std::int32_t fourcc) {
  v4l2_format format{};
  format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  v4l2_pix_format& pixels = format.fmt.pix;
  pixels.width = static_cast<std::uint32_t>(setup_.lens.width);
  pixels.height = static_cast<std::uint32_t>(setup_.lens.height);
  pixels.pixelformat = static_cast<std::uint32_t>(fourcc);
  pixels.field = V4L2_FIELD_NONE;
  demand(calls_.control(fd_, VIDIOC_S_FMT, &format), "set its format");
  return {static_cast<std::int32_t>(pixels.pixelformat), static_cast<int>(pixels.width),
          static_cast<int>(pixels.height), pixels.bytesperline, pixels.field == V4L2_FIELD_NONE};
}

void VideoDevice::chooseFormat() {
  std::string objections;
  for (const std::int32_t fourcc : usableFormats(setup_.camera, offeredFormats())) {
    format_ = trySetting(fourcc);
    const std::string why = objection(format_, fourcc, setup_.lens);
    if (why.empty()) {
      return;
    }
    objections += (objections.empty() ? "" : ", and ") + why;
  }
  refuse(objections);
}

void VideoDevice::mapBuffers() {
  v4l2_requestbuffers request{};
  request.count = kBuffers;
  request.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  request.memory = V4L2_MEMORY_MMAP;
  demand(calls_.control(fd_, VIDIOC_REQBUFS, &request), "lend its buffers");
  if (request.count < 2) {
    refuse(fmt::format("lends {} buffers, 2 are needed; other programs use its memory", request.count));
  }
  for (std::uint32_t i = 0; i < request.count; ++i) {
    v4l2_buffer buffer = captureBuffer(i);
    demand(calls_.control(fd_, VIDIOC_QUERYBUF, &buffer), "describe its buffers");
    void* start = calls_.map(fd_, buffer.length, buffer.m.offset);
    if (start == nullptr) {
      refuse("does not share its buffers; is the memory full?");
    }
    buffers_.push_back({start, buffer.length});
    demand(calls_.control(fd_, VIDIOC_QBUF, &buffer), "take its buffers back");
  }
}

std::optional<Frame> VideoDevice::next(std::chrono::milliseconds timeout) {
  if (calls_.wait(fd_, timeout) != SystemCalls::Wait::kReady) {
    return std::nullopt;
  }
  v4l2_buffer buffer = captureBuffer(0);
  const int result = calls_.control(fd_, VIDIOC_DQBUF, &buffer);
  // A driver that was unbound says EINVAL, a cable that was pulled ENODEV. Ready without a buffer is a fault.
  if (result == -EINVAL) {
    demand(-ENODEV, "");
  }
  demand(result == -EAGAIN ? -EIO : result, "deliver a picture");
  if (buffer.index >= buffers_.size()) {
    refuse(fmt::format("delivers buffer {} of {}; its driver is broken", buffer.index, buffers_.size()));
  }
  const Memory& memory = buffers_[buffer.index];
  Frame frame;
  frame.bytes = {static_cast<const std::uint8_t*>(memory.start),
                 std::min<std::size_t>(buffer.bytesused, memory.size)};
  frame.sequence = buffer.sequence;
  frame.damaged = (buffer.flags & V4L2_BUF_FLAG_ERROR) != 0;
  frame.index = buffer.index;
  // Whether it is of the monotonic clock shows in its value: v4l2loopback's is without saying so.
  frame.stamp = {
      buffer.timestamp.tv_sec * std::int64_t{1'000'000'000} + buffer.timestamp.tv_usec * std::int64_t{1'000},
      (buffer.flags & V4L2_BUF_FLAG_TSTAMP_SRC_MASK) == V4L2_BUF_FLAG_TSTAMP_SRC_SOE};
  return frame;
}

void VideoDevice::release(const Frame& frame) {
  v4l2_buffer buffer = captureBuffer(frame.index);
  demand(calls_.control(fd_, VIDIOC_QBUF, &buffer), "take a buffer back");
}

}  // namespace rubble::camera
