#include "recognizer/recognizer_node.h"

#include <gmock/gmock.h>

#include <bot_core/image_t.hpp>
#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <rubble/command_t.hpp>
#include <rubble/detections_t.hpp>
#include <rubble/mono_features_t.hpp>
#include <rubble/object_notice_t.hpp>

#include "lcm_io/channels.h"
#include "lcm_io/jpeg.h"
#include "lcm_io/pixel_format.h"
#include "lcm_io/replay_hub.h"
#include "notice_picture.h"
#include "novelty.h"
#include "recognizer_node_config.h"
#include "scene/signs.h"
#include "support/error_text.h"

namespace rubble::recognizer {
namespace {

using common::Utime;

constexpr Utime kSecond = common::kMicrosecondsPerSecond;

TEST(Novelty, TellsOnceUntilItWasAwayForLong) {
  Novelty novelty(3, 10.0);
  EXPECT_FALSE(novelty.see("poison", 1 * kSecond));
  EXPECT_FALSE(novelty.see("poison", 2 * kSecond));
  EXPECT_TRUE(novelty.see("poison", 3 * kSecond));
  EXPECT_FALSE(novelty.see("poison", 4 * kSecond));
  EXPECT_FALSE(novelty.see("poison", 20 * kSecond)) << "anew, but only once so far";
  EXPECT_FALSE(novelty.see("poison", 21 * kSecond));
  EXPECT_TRUE(novelty.see("poison", 22 * kSecond));
}

TEST(NoticePicture, FitsAndIsAJpeg) {
  cv::Mat picture(720, 1280, CV_8UC3);
  cv::randu(picture, 0, 255);  // As hard to compress as can be.
  const std::array<cv::Point2f, 4> quad{{{-50.0F, 20.0F}, {90.0F, 20.0F}, {90.0F, 160.0F}, {-50.0F, 1e9F}}};
  const auto jpeg = noticeJpeg(picture, quad, "poison", 100'000);
  EXPECT_LE(jpeg.size(), 100'000);
  EXPECT_TRUE(lcm_io::isWholeJpeg(jpeg));
}

/// The node without a vocabulary on a hub, and a camera that sees a QR code.
class RecognizerNodeTest : public testing::Test {
 protected:
  RecognizerNodeTest() { start("recognizer.period=0"); }

  void start(const char* setting) {
    common::Config config;
    config.addOverride(setting);
    node_.reset();
    hub_ = std::make_unique<lcm_io::ReplayHub>();
    node_ = makeNode({.bus = hub_->endpoint(), .config = config, .state_dir = {}});
    lcm_io::Bus& ears = hub_->endpoint();
    ears.subscribe<rubble::detections_t>(lcm_io::channel::kDetections,
                                         [this](const auto& m) { detections_.push_back(m); });
    ears.subscribe<rubble::object_notice_t>(lcm_io::channel::kObjectNotice,
                                            [this](const auto& m) { notices_.push_back(m); });
  }

  template <typename Message>
  void feed(const char* channel, const Message& message) {
    now_ += 1000;
    hub_->feed({channel, now_, lcm_io::encode(message)});
    hub_->deliverPending();
  }

  static bot_core::image_t pictureAt(Utime utime) {
    cv::Mat picture(240, 320, CV_8UC3, cv::Scalar::all(140));
    arena_sim::drawQrCode("room-7", 160).copyTo(picture(cv::Rect(80, 40, 160, 160)));
    bot_core::image_t message{};
    message.utime = utime;
    message.width = picture.cols;
    message.height = picture.rows;
    message.row_stride = picture.cols;
    message.pixelformat = lcm_io::kMjpg;
    cv::imencode(".jpg", picture, message.data);
    message.size = static_cast<std::int32_t>(message.data.size());
    return message;
  }

  static rubble::mono_features_t featuresAt(Utime utime) {
    rubble::mono_features_t message{};
    message.utime = utime;
    message.width = 320;
    message.height = 240;
    return message;
  }

  void see(Utime utime) {
    feed(lcm_io::channel::kCamera, pictureAt(utime));
    feed(lcm_io::channel::kMonoFeatures, featuresAt(utime));
  }

  std::unique_ptr<lcm_io::ReplayHub> hub_;
  Utime now_ = 1'000'000'000;
  std::unique_ptr<lcm_io::Node> node_;
  std::vector<rubble::detections_t> detections_;
  std::vector<rubble::object_notice_t> notices_;
};

TEST_F(RecognizerNodeTest, CodesAreReadAndTheOperatorHearsOfThemOnce) {
  for (int i = 1; i <= 10; ++i) {
    see(i * 33'333);
  }
  ASSERT_EQ(detections_.size(), 10);
  ASSERT_EQ(detections_.back().n, 1);
  const rubble::detection_t& code = detections_.back().detections.front();
  EXPECT_EQ(code.kind, "qr");
  EXPECT_EQ(code.text, "room-7");
  EXPECT_NEAR(0.25F * (code.quad_x[0] + code.quad_x[1] + code.quad_x[2] + code.quad_x[3]), 159.5F, 2.0F);
  ASSERT_EQ(notices_.size(), 1);
  EXPECT_EQ(notices_.front().detection.text, "room-7");
  EXPECT_EQ(notices_.front().njpeg, static_cast<std::int32_t>(notices_.front().jpeg.size()));
  EXPECT_EQ(node_->status().counters.at("pictures"), 10);
  EXPECT_EQ(node_->status().counters.at("pictures_left_out"), 0);
}

TEST_F(RecognizerNodeTest, LooksNoOftenerThanItsPeriod) {
  start("recognizer.period=0.1");
  for (int i = 1; i <= 30; ++i) {
    see(i * 33'333);
  }
  EXPECT_EQ(node_->status().counters.at("pictures"), 10);
  EXPECT_EQ(node_->status().counters.at("pictures_left_out"), 0) << "that is by plan";
}

TEST_F(RecognizerNodeTest, PicturesThatWereDroppedAreCounted) {
  for (const int i : {1, 2, 3, 7, 8}) {
    see(i * 33'333);
  }
  EXPECT_EQ(node_->status().counters.at("pictures_left_out"), 3);
  EXPECT_THAT(node_->status().detail, testing::HasSubstr("cannot keep up"));
}

TEST_F(RecognizerNodeTest, FeaturesWithoutTheirPictureAndBadInputAreHarmless) {
  feed(lcm_io::channel::kMonoFeatures, featuresAt(33'333));
  EXPECT_TRUE(detections_.empty());
  feed(lcm_io::channel::kCamera, pictureAt(66'666));
  auto features = featuresAt(66'666);
  features.noctaves = 2;
  features.octave = {0, 1};
  feed(lcm_io::channel::kMonoFeatures, features);
  EXPECT_TRUE(detections_.empty());
  auto picture = pictureAt(99'999);
  picture.data.resize(picture.data.size() / 2);
  picture.size = static_cast<std::int32_t>(picture.data.size());
  feed(lcm_io::channel::kCamera, picture);
  feed(lcm_io::channel::kMonoFeatures, featuresAt(99'999));
  EXPECT_TRUE(detections_.empty());
  rubble::command_t command;
  command.target = "recognizer";
  command.verb = "load";
  command.argument = "/nowhere/objects.vocabulary";
  feed(lcm_io::channel::kCommand, command);
  see(133'333);
  EXPECT_EQ(detections_.size(), 1) << "it goes on";
}

TEST(RecognizerNode, AVocabularyThatIsNotThereIsAnError) {
  common::Config config;
  config.addOverride("recognizer.vocabulary=/nowhere/objects.vocabulary");
  lcm_io::ReplayHub hub;
  EXPECT_THAT(test::errorOf([&] { makeNode({.bus = hub.endpoint(), .config = config, .state_dir = {}}); }),
              testing::HasSubstr("/nowhere/objects.vocabulary"));
}

}  // namespace
}  // namespace rubble::recognizer
