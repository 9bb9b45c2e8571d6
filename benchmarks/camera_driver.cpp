// What the camera driver costs: the node on a live bus, a played device of 640 x 480 pixels at its real rate,
// and the process's CPU time for each picture.
//   build/release/bin/camera_driver [SECONDS]
#include <fmt/format.h>
#include <sys/resource.h>

#include <cstdlib>
#include <random>
#include <thread>

#include "camera_node.h"
#include "lcm_io/channels.h"
#include "lcm_io/lcm_bus.h"
#include "lcm_io/pixel_format.h"
#include "scripted_camera.h"
#include "support/lcm_url.h"

namespace {

using namespace rubble;
using Clock = std::chrono::steady_clock;

constexpr int kRate = 30;

/// In real time.
class PacedCamera : public camera::ScriptedCamera {
 public:
  Wait wait(int fd, std::chrono::milliseconds timeout) override {
    next_ += std::chrono::nanoseconds(1'000'000'000 / kRate);
    std::this_thread::sleep_until(next_);
    return ScriptedCamera::wait(fd, timeout);
  }

 private:
  Clock::time_point next_ = Clock::now();
};

double cpuSeconds() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
         1e-6 * static_cast<double>(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
}

std::vector<std::uint8_t> contentOf(std::uint32_t format, const common::RobotConfig::Intrinsics& lens) {
  std::mt19937 random(1);
  const auto width = static_cast<std::size_t>(lens.width);
  const std::size_t pixel = format == V4L2_PIX_FMT_YUYV ? 2 : 1;
  std::vector<std::uint8_t> bytes(pixel * width * static_cast<std::size_t>(lens.height));
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    const bool colour = pixel == 2 && i % 2 == 1;
    bytes[i] = static_cast<std::uint8_t>(colour ? 120 : 60 + i / pixel % width / 8 + random() % 24);
  }
  if (format != V4L2_PIX_FMT_MJPEG) {
    return bytes;
  }
  camera::JpegEncoder encoder(85);
  const lcm_io::ByteView jpeg = encoder.encodeGrey({bytes, width, lens.width, lens.height});
  return {jpeg.begin(), jpeg.end()};
}

void measure(std::uint32_t format, std::chrono::seconds duration) {
  camera::CameraSetup setup;
  setup.lens.rate = kRate;
  auto device = std::make_unique<PacedCamera>();
  device->rate = kRate;
  device->formats = {format};
  device->content = contentOf(format, setup.lens);
  const std::size_t bytes = device->content.size();
  lcm_io::LcmBus bus(test::privateLcmUrl(), "camera");
  camera::CameraNode node(bus, std::move(device), setup);
  const auto end = Clock::now() + duration;
  const double begin = cpuSeconds();
  while (Clock::now() < end) {
    bus.dispatch(std::chrono::milliseconds(20));
    node.advance(bus.now());
  }
  const double used = cpuSeconds() - begin;
  const auto pictures = static_cast<double>(bus.published().at(lcm_io::channel::kCamera).count);
  const lcm_io::NodeStatus status = node.status();
  fmt::print("{}: {} bytes, {:.0f} pictures ({}{}), {:.3f} ms CPU each, {:.2f} % of a core at {} Hz\n",
             camera::formatName(static_cast<std::int32_t>(format)), bytes, pictures, status.state,
             status.detail.empty() ? "" : ": " + status.detail, 1e3 * used / pictures,
             100.0 * used / pictures * kRate, kRate);
}

}  // namespace

int main(int argc, char** argv) {
  const std::chrono::seconds duration(argc > 1 ? std::atoi(argv[1]) : 10);
  for (const std::uint32_t format : {V4L2_PIX_FMT_MJPEG, V4L2_PIX_FMT_YUYV, V4L2_PIX_FMT_GREY}) {
    measure(format, duration);
  }
}
