// The real calls, as far as a kernel without cameras goes; tests/kernel has one with.
#include "system_calls.h"

#include <gmock/gmock.h>

#include <cerrno>
#include <thread>

#include "pictures.h"
#include "support/error_text.h"
#include "video_device.h"

namespace rubble::camera {
namespace {

TEST(SystemCalls, AMissingNodeIsNamed) {
  const auto calls = makeSystemCalls();
  EXPECT_EQ(calls->open("/dev/no-camera"), -ENOENT);
}

TEST(SystemCalls, AFileThatIsNoCameraIsRefused) {
  const auto calls = makeSystemCalls();
  CameraSetup setup = smallSetup();
  setup.camera.device = "/dev/null";
  EXPECT_THAT(test::errorOf([&] { VideoDevice device(*calls, setup); }),
              testing::StartsWith("/dev/null is no V4L2 device"));
}

TEST(SystemCalls, WakeEndsWaitsOfAnyThreadNowAndLater) {
  const auto calls = makeSystemCalls();
  EXPECT_EQ(calls->wait(-1, std::chrono::milliseconds(1)), SystemCalls::Wait::kTimeout);
  std::thread other([&] { calls->wake(); });
  EXPECT_EQ(calls->wait(-1, std::chrono::minutes(1)), SystemCalls::Wait::kWoken);
  other.join();
  EXPECT_EQ(calls->wait(-1, std::chrono::minutes(1)), SystemCalls::Wait::kWoken);
}

TEST(SystemCalls, ClocksGoOn) {
  const auto calls = makeSystemCalls();
  const ClockReading first = calls->readClocks();
  const ClockReading second = calls->readClocks();
  EXPECT_LE(first.monotonic_before, first.monotonic_after);
  EXPECT_LE(first.monotonic_after, second.monotonic_before);
  EXPECT_GT(first.epoch, 1'600'000'000'000'000'000);
}

}  // namespace
}  // namespace rubble::camera
