#pragma once

#include <optional>
#include <vector>

#include "controls.h"
#include "device_error.h"
#include "frame_format.h"
#include "lcm_io/codec.h"
#include "system_calls.h"

namespace rubble::camera {

/// A buffer that the device has filled; lent until release().
struct Frame {
  lcm_io::ByteView bytes;
  std::uint32_t sequence = 0;
  /// The device says that the content is not whole.
  bool damaged = false;
  BufferStamp stamp;
  std::uint32_t index = 0;
};

/// A V4L2 capture device that streams into shared memory, from construction to destruction. Every failure is
/// a DeviceError; then nothing helps but a new one.
class VideoDevice {
 public:
  /// Opens, asks for format, size, rate and controls, checks what the driver made of that, and starts.
  VideoDevice(SystemCalls& calls, const CameraSetup& setup);
  ~VideoDevice();
  VideoDevice(const VideoDevice&) = delete;
  VideoDevice& operator=(const VideoDevice&) = delete;

  /// Empty when nothing came within the time, or after SystemCalls::wake().
  std::optional<Frame> next(std::chrono::milliseconds timeout);
  void release(const Frame& frame);

  const FrameFormat& format() const { return format_; }
  const ControlOutcome& controls() const { return controls_; }

 private:
  struct Memory {
    void* start = nullptr;
    std::size_t size = 0;
  };

  void start();
  void checkCapabilities();
  void chooseFormat();
  std::vector<std::int32_t> offeredFormats();
  FrameFormat trySetting(std::int32_t fourcc);
  void mapBuffers();
  void close();
  /// The result when it is no error. `what` was tried.
  int demand(int result, const char* what);
  [[noreturn]] void refuse(const std::string& what) const;

  SystemCalls& calls_;
  const CameraSetup& setup_;
  const std::string& name_;
  int fd_ = -1;
  std::vector<Memory> buffers_;
  FrameFormat format_;
  ControlOutcome controls_;
};

}  // namespace rubble::camera
