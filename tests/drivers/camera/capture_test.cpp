#include "capture.h"

#include <gmock/gmock.h>

#include <cerrno>

#include "pictures.h"
#include "scripted_camera.h"
#include "support/allocation_watch.h"

namespace rubble::camera {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

using std::chrono::milliseconds;
using Event = ScriptedCamera::Event;

constexpr std::int64_t kPeriodUs = ScriptedCamera::kPeriod / 1000;

class CaptureTest : public testing::Test {
 protected:
  CaptureTest() { camera_.content = jpegPicture(); }

  Capture& capture() {
    if (!capture_) {
      capture_ = std::make_unique<Capture>(camera_, setup_, queue_, [this] { takePictures(); });
    }
    return *capture_;
  }
  void step(int steps) {
    for (int i = 0; i < steps; ++i) {
      capture().step();
    }
  }
  /// Opens, then one picture a step.
  void start(int pictures = 1) { step(1 + pictures); }

  void takePictures() {
    while (auto picture = queue_.pop()) {
      stamps_.push_back(picture->utime);
      last_ = *picture;
      queue_.giveBack(std::move(picture));
    }
  }
  std::int64_t count(const std::string& counter) { return capture().status().counters.at(counter); }
  std::string state() { return capture().status().state; }
  std::string detail() { return capture().status().detail; }

  ScriptedCamera camera_;
  CameraSetup setup_ = smallSetup();
  PictureQueue queue_{4};
  std::unique_ptr<Capture> capture_;
  std::vector<common::Utime> stamps_;
  bot_core::image_t last_;
};

TEST_F(CaptureTest, StreamsWithRegularStampsOfTheEpoch) {
  EXPECT_EQ(state(), "starting");
  EXPECT_EQ(detail(), "/dev/v4l/by-path/front has given no picture yet");
  start(10);
  EXPECT_EQ(state(), "streaming");
  EXPECT_EQ(detail(), "");
  ASSERT_EQ(stamps_.size(), 10U);
  for (std::size_t i = 1; i < stamps_.size(); ++i) {
    EXPECT_EQ(stamps_[i] - stamps_[i - 1], kPeriodUs);
  }
  EXPECT_EQ(stamps_.back(), (ScriptedCamera::kEpoch + camera_.time - ScriptedCamera::kTransfer) / 1000);
  EXPECT_EQ(last_.data, camera_.content);
  EXPECT_EQ(last_.nmetadata, 0) << "the camera chooses its exposure and does not tell";
}

TEST_F(CaptureTest, AKnownExposureIsToldAndTheStampIsItsMiddle) {
  camera_.controls = {{V4L2_CID_EXPOSURE_AUTO, 3}, {V4L2_CID_EXPOSURE_ABSOLUTE, 1}};
  setup_.camera.exposure = 0.01;
  camera_.events.resize(1);
  camera_.events[0].flags |= V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
  start();
  EXPECT_EQ(camera_.controls.at(V4L2_CID_EXPOSURE_AUTO), V4L2_EXPOSURE_MANUAL);
  EXPECT_EQ(camera_.controls.at(V4L2_CID_EXPOSURE_ABSOLUTE), 100);
  ASSERT_EQ(last_.nmetadata, 1);
  EXPECT_EQ(last_.metadata[0].key, "exposure_us");
  EXPECT_EQ(std::string(last_.metadata[0].value.begin(), last_.metadata[0].value.end()), "10000");
  const std::int64_t stamp = (ScriptedCamera::kEpoch + camera_.time - ScriptedCamera::kTransfer) / 1000;
  EXPECT_EQ(last_.utime, stamp + 5000);
  start(0);
  EXPECT_EQ(last_.utime, stamp + kPeriodUs - 5000) << "without the flag the stamp is the exposure's end";
  EXPECT_EQ(detail(), "");
}

TEST_F(CaptureTest, WishesThatAreNotGrantedAreSaidAndNothingElse) {
  camera_.rate = 15.0;
  camera_.controls = {{V4L2_CID_GAIN, 0}};
  setup_.camera.exposure = 0.01;
  setup_.camera.gain = 7;
  start();
  EXPECT_EQ(state(), "streaming");
  EXPECT_EQ(detail(),
            "/dev/v4l/by-path/front gives 15 Hz for the 25 Hz of robot.camera.rate; set that to a rate it "
            "has; /dev/v4l/by-path/front has "
            "no control for camera.exposure (0.1 ms); leave it out");
  EXPECT_EQ(camera_.controls.at(V4L2_CID_GAIN), 7);
}

TEST_F(CaptureTest, AWishOutOfRangeNamesTheRange) {
  camera_.controls = {{V4L2_CID_GAIN, 0}};
  camera_.largest_control = 5;
  setup_.camera.gain = 7;
  start();
  EXPECT_EQ(
      detail(),
      "/dev/v4l/by-path/front uses 5 for camera.gain, which was to be 7; it takes 0 .. 5 in steps of 1");
}

TEST_F(CaptureTest, WaitsForADeviceWithGrowingPauses) {
  camera_.present = false;
  step(7);
  EXPECT_EQ(state(), "no_device");
  EXPECT_THAT(detail(), StartsWith("/dev/v4l/by-path/front is not there; plug the camera in"));
  EXPECT_THAT(camera_.pauses,
              ElementsAre(milliseconds(100), milliseconds(200), milliseconds(400), milliseconds(800),
                          milliseconds(1600), milliseconds(2000), milliseconds(2000)));
  camera_.present = true;
  start();
  EXPECT_EQ(state(), "streaming");
  EXPECT_THAT(detail(), StartsWith("back after: /dev/v4l/by-path/front is not there"));
  step(7 * 25);
  EXPECT_NE(detail(), "");
  step(2 * 25);
  EXPECT_EQ(detail(), "") << "old news";
  camera_.present = false;
  step(1);
  EXPECT_EQ(camera_.pauses.back(), milliseconds(100)) << "pictures make the pauses short again";
}

TEST_F(CaptureTest, AnyFaultDropsTheDeviceWholeAndOpensItAnew) {
  start();
  const int in_use = camera_.inUse();
  int opened = 1;
  for (const int error : {-EIO, -ENODEV, -EINVAL, -EAGAIN, -EPROTO}) {
    camera_.events.push_back({.error = error});
    step(1);
    EXPECT_EQ(camera_.inUse(), 0) << error;
    EXPECT_THAT(detail(), StartsWith("/dev/v4l/by-path/front ")) << error;
    EXPECT_NE(state(), "streaming");
    start();
    EXPECT_EQ(state(), "streaming");
    EXPECT_EQ(camera_.inUse(), in_use);
    EXPECT_EQ(count("opened"), ++opened);
  }
  EXPECT_EQ(count("faults"), 5);
  EXPECT_EQ(count("missing"), 0) << "a new stream has its own numbers";
  camera_.refusals = {{VIDIOC_QBUF, -EIO}};
  step(1);
  EXPECT_THAT(detail(), HasSubstr("cannot take a buffer back"));
  EXPECT_EQ(camera_.inUse(), 0);
}

TEST_F(CaptureTest, WhatIsRefusedAtTheStartLeavesNothingOpen) {
  for (const unsigned long request : {VIDIOC_QUERYCAP, VIDIOC_ENUM_FMT, VIDIOC_S_FMT, VIDIOC_REQBUFS,
                                      VIDIOC_QUERYBUF, VIDIOC_QBUF, VIDIOC_STREAMON}) {
    camera_.refusals = {{request, -EBUSY}};
    step(1);
    EXPECT_EQ(state(), "refused") << request;
    EXPECT_EQ(camera_.inUse(), 0) << request;
  }
  EXPECT_EQ(
      detail(),
      "/dev/v4l/by-path/front cannot start streaming: Device or resource busy; another program uses it: "
      "`fuser -v` names it");
  camera_.refusals = {{VIDIOC_QUERYCAP, -ENOTTY}};
  step(1);
  EXPECT_THAT(detail(), HasSubstr("is no V4L2 device"));
}

TEST_F(CaptureTest, AFormatThatTheDriverChangesIsLeftForTheNext) {
  camera_.change = [](v4l2_pix_format& pixels) {
    if (pixels.pixelformat == V4L2_PIX_FMT_MJPEG) {
      pixels.width *= 2;
    }
  };
  camera_.content = yuyvPicture();
  start();
  EXPECT_EQ(state(), "streaming");
  EXPECT_NE(last_.data, camera_.content) << "YUYV as JPEG";
  EXPECT_EQ(last_.width, kWidth);
}

TEST_F(CaptureTest, ASizeThatTheDriverChangesEverywhereIsRefused) {
  camera_.formats = {V4L2_PIX_FMT_YUYV};
  camera_.change = [](v4l2_pix_format& pixels) { pixels.height = 36; };
  step(1);
  EXPECT_EQ(state(), "refused");
  EXPECT_EQ(
      detail(),
      "/dev/v4l/by-path/front gives 96 x 36 pixels in YUYV, but robot.camera is calibrated for 96 x 64; set "
      "robot.camera to a size it has and calibrate for it");
}

TEST_F(CaptureTest, GapsAreCountedAndSaid) {
  start();
  camera_.events.push_back({.gap = 3});
  step(2);
  EXPECT_EQ(count("missing"), 3);
  EXPECT_EQ(state(), "streaming");
  EXPECT_THAT(detail(), HasSubstr("leaves out pictures"));
}

TEST_F(CaptureTest, DamagedPicturesAreDroppedAndCounted) {
  start();
  camera_.events.push_back({.flags = V4L2_BUF_FLAG_ERROR});
  camera_.events.push_back({.bytes = 100});
  camera_.events.push_back({.bytes = 0});
  step(4);
  EXPECT_EQ(count("damaged"), 3);
  EXPECT_EQ(count("missing"), 0);
  EXPECT_EQ(stamps_.size(), 2U);
  EXPECT_THAT(detail(), HasSubstr("gives damaged pictures"));
}

TEST_F(CaptureTest, ASilentDeviceIsOpenedAnewAndStaysSilentInHealth) {
  start();
  camera_.pictures = 0;
  step(1);
  EXPECT_EQ(state(), "silent");
  EXPECT_THAT(detail(), HasSubstr("has given no picture for 2 s"));
  EXPECT_EQ(camera_.inUse(), 0);
  step(1);
  EXPECT_EQ(camera_.opened, 2);
  EXPECT_EQ(state(), "silent") << "an open device is no picture yet";
  camera_.pictures = 1;
  step(1);
  EXPECT_EQ(state(), "streaming");
}

TEST_F(CaptureTest, OnlyDamagedPicturesAreAFaultOfTheirOwn) {
  start();
  camera_.content.clear();
  step(2 * 25);
  EXPECT_EQ(state(), "silent");
  EXPECT_THAT(detail(), HasSubstr("only damaged pictures for 2 s"));
}

TEST_F(CaptureTest, PicturesWithAStampOfAnotherClockCarryTheirArrival) {
  camera_.events.push_back({.clock_error = -ScriptedCamera::kEpoch});
  start();
  EXPECT_EQ(last_.utime, (ScriptedCamera::kEpoch + camera_.time) / 1000);
  EXPECT_EQ(count("stamped_on_arrival"), 1);
  EXPECT_THAT(detail(), HasSubstr("no usable stamps"));
}

TEST_F(CaptureTest, ASteadyStreamAsksForNoMemory) {
  camera_.controls = {{V4L2_CID_EXPOSURE_AUTO, 3}, {V4L2_CID_EXPOSURE_ABSOLUTE, 1}};
  setup_.camera.exposure = 0.01;
  for (const std::uint32_t format : {V4L2_PIX_FMT_MJPEG, V4L2_PIX_FMT_YUYV}) {
    capture_.reset();
    camera_.formats = {format};
    camera_.content = format == V4L2_PIX_FMT_MJPEG ? jpegPicture() : yuyvPicture();
    capture_ = std::make_unique<Capture>(camera_, setup_, queue_, [this] { queue_.giveBack(queue_.pop()); });
    start(10);
    test::watchAllocations();
    step(100);
    EXPECT_EQ(test::largestAllocation(), 0U);
  }
}

}  // namespace
}  // namespace rubble::camera
