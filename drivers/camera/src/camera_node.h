#pragma once

#include <atomic>
#include <memory>
#include <rubble/camera_info_t.hpp>
#include <thread>

#include "capture.h"
#include "lcm_io/bus.h"
#include "lcm_io/node.h"
#include "lcm_io/process.h"

namespace rubble::camera {

/// The driver between the device and the bus: a thread captures, the bus's thread publishes CAMERA, and while
/// pictures flow the calibration as CAMERA_INFO at 1 Hz.
class CameraNode : public lcm_io::Node {
 public:
  CameraNode(lcm_io::Bus& bus, std::unique_ptr<SystemCalls> calls, const CameraSetup& setup);
  ~CameraNode() override;

  void advance(common::Utime now) override;
  void finish() override;
  lcm_io::NodeStatus status() const override;

 private:
  lcm_io::Bus& bus_;
  const std::unique_ptr<SystemCalls> calls_;
  rubble::camera_info_t info_;
  PictureQueue queue_;
  Capture capture_;
  std::atomic<bool> stopping_ = false;
  std::thread thread_;
};

/// The node on the real kernel, as sections `camera` and `robot` say. Throws common::Error where the bus is a
/// log.
std::unique_ptr<lcm_io::Node> makeCameraNode(const lcm_io::ProcessContext& context);

}  // namespace rubble::camera
