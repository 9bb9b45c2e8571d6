#include "camera_node.h"

#include <gmock/gmock.h>

#include <thread>

#include "lcm_io/channels.h"
#include "lcm_io/replay_hub.h"
#include "pictures.h"
#include "scripted_camera.h"
#include "support/error_text.h"
#include "support/wait_until.h"

namespace rubble::camera {
namespace {

using Level = lcm_io::NodeStatus::Level;

class CameraNodeTest : public testing::Test {
 protected:
  CameraNodeTest() {
    camera_->content = jpegPicture();
    camera_->pictures = 3;
    camera_->blocks = true;
    lcm_io::Bus& listener = hub_.endpoint();
    listener.subscribe<bot_core::image_t>(lcm_io::channel::kCamera,
                                          [this](const auto& m) { pictures_.push_back(m); });
    listener.subscribe<rubble::camera_info_t>(lcm_io::channel::kCameraInfo,
                                              [this](const auto& m) { infos_.push_back(m); });
  }

  /// Until the thread has handed over what it has, and that is published.
  bool hear(std::size_t pictures) {
    return test::waitUntil([&] {
      node_->advance(hub_.now());
      hub_.deliverPending();
      return pictures_.size() >= pictures;
    });
  }

  lcm_io::ReplayHub hub_;
  std::unique_ptr<ScriptedCamera> camera_ = std::make_unique<ScriptedCamera>();
  std::unique_ptr<CameraNode> node_;
  std::vector<bot_core::image_t> pictures_;
  std::vector<rubble::camera_info_t> infos_;
};

TEST_F(CameraNodeTest, PublishesPicturesAndTheCalibrationWithThem) {
  hub_.advanceTo(5'000'000);
  const auto content = camera_->content;
  node_ = std::make_unique<CameraNode>(hub_.endpoint(), std::move(camera_), smallSetup());
  ASSERT_TRUE(hear(3));
  EXPECT_EQ(pictures_.back().data, content);
  ASSERT_EQ(infos_.size(), 1U) << "five a second";
  EXPECT_EQ(infos_[0].utime, 5'000'000);
  EXPECT_EQ(infos_[0].width, kWidth);
  EXPECT_EQ(infos_[0].rate_hz, 25.0);
  EXPECT_EQ(infos_[0].fx, 370.0);
  EXPECT_EQ(infos_[0].model, "pinhole");
  EXPECT_EQ(infos_[0].ndistortion, 4);
  EXPECT_EQ(node_->status().level, Level::kOk);
  EXPECT_EQ(node_->status().state, "streaming");
  node_->finish();
}

TEST_F(CameraNodeTest, WithoutACameraItIsAnErrorAndNothingIsPublished) {
  camera_->present = false;
  node_ = std::make_unique<CameraNode>(hub_.endpoint(), std::move(camera_), smallSetup());
  ASSERT_TRUE(test::waitUntil([&] { return node_->status().state == "no_device"; }));
  EXPECT_EQ(node_->status().level, Level::kError);
  node_->advance(hub_.now());
  hub_.deliverPending();
  EXPECT_TRUE(pictures_.empty());
  EXPECT_TRUE(infos_.empty()) << "who plays a log has its own";
}

TEST_F(CameraNodeTest, ALogIsNoBusForADriver) {
  EXPECT_THAT(test::errorOf([&] { makeCameraNode({.bus = hub_.endpoint(), .config = {}, .state_dir = {}}); }),
              testing::HasSubstr("reads no log"));
}

/// What the process does: the capture's thread ends the bus's wait.
class WakingBus : public lcm_io::Bus {
 public:
  bool dispatch(std::chrono::milliseconds /*timeout*/) override { return false; }
  void wake() override { ++wakes; }
  bool ended() const override { return false; }
  common::Utime now() const override { return 0; }
  std::atomic<int> wakes = 0;

 protected:
  void attach(const std::string& /*channel*/) override {}
  bool send(const std::string& /*channel*/, lcm_io::ByteView /*data*/) override { return true; }
};

TEST_F(CameraNodeTest, WakesTheBusForEveryPicture) {
  WakingBus bus;
  CameraNode node(bus, std::move(camera_), smallSetup());
  EXPECT_TRUE(test::waitUntil([&] { return bus.wakes == 3; }));
}

}  // namespace
}  // namespace rubble::camera
