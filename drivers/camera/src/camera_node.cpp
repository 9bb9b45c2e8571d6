#include "camera_node.h"

#include <cstdlib>

#include "common/error.h"
#include "lcm_io/channels.h"
#include "lcm_io/conversions.h"

namespace rubble::camera {

namespace {

/// A little shorter than the promised 5 Hz: it goes out with a picture.
constexpr common::Utime kInfoInterval = 180'000;

rubble::camera_info_t infoOf(const common::RobotConfig::Intrinsics& lens) {
  rubble::camera_info_t info;
  info.utime = 0;
  lcm_io::intrinsicsToMessage(lens, info);
  return info;
}

}  // namespace

CameraNode::CameraNode(lcm_io::Bus& bus, std::unique_ptr<SystemCalls> calls, const CameraSetup& setup)
    : bus_(bus),
      calls_(std::move(calls)),
      info_(infoOf(setup.lens)),
      queue_(lcm_io::findChannel(lcm_io::channel::kCamera)->queue_capacity),
      capture_(*calls_, setup, queue_, [this] { bus_.wake(); }),
      thread_([this] {
        while (!stopping_) {
          capture_.step();
        }
      }) {}

CameraNode::~CameraNode() { finish(); }

void CameraNode::advance(common::Utime now) {
  while (PictureQueue::Picture picture = queue_.pop()) {
    bus_.publish(lcm_io::channel::kCamera, *picture);
    queue_.giveBack(std::move(picture));
    // Also when the clock was set back.
    if (std::abs(now - info_.utime) >= kInfoInterval) {
      info_.utime = now;
      bus_.publish(lcm_io::channel::kCameraInfo, info_);
    }
  }
}

void CameraNode::finish() {
  stopping_ = true;
  calls_->wake();
  if (thread_.joinable()) {
    thread_.join();
  }
}

lcm_io::NodeStatus CameraNode::status() const {
  using Level = lcm_io::NodeStatus::Level;
  CaptureStatus capture = capture_.status();
  Level level = Level::kError;
  if (capture.state == device_state::kStreaming) {
    level = capture.detail.empty() ? Level::kOk : Level::kDegraded;
  } else if (capture.state == device_state::kStarting) {
    level = Level::kDegraded;
  }
  return {level, std::move(capture.state), std::move(capture.detail), std::move(capture.counters)};
}

std::unique_ptr<lcm_io::Node> makeCameraNode(const lcm_io::ProcessContext& context) {
  if (!context.live) {
    throw common::Error("rubble-camera drives a camera and reads no log; give a live --lcm-url");
  }
  const CameraSetup setup{context.config.read<CameraConfig>("camera"),
                          context.config.read<common::RobotConfig>("robot").intrinsics};
  return std::make_unique<CameraNode>(context.bus, makeSystemCalls(), setup);
}

}  // namespace rubble::camera
