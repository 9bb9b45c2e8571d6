#include "slam_mono/slam_mono_node.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bot_core/image_t.hpp>
#include <cmath>
#include <map>
#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <rubble/camera_info_t.hpp>
#include <rubble/mono_features_t.hpp>
#include <rubble/mono_map_t.hpp>
#include <rubble/mono_pose_t.hpp>
#include <set>
#include <string>
#include <vector>

#include "lcm_io/channels.h"
#include "lcm_io/pixel_format.h"
#include "lcm_io/replay_hub.h"
#include "support/temp_dir.h"

namespace rubble {
namespace {

using common::Utime;
using rubble::mono_pose_t;

constexpr int kWidth = 640;
constexpr int kHeight = 480;
constexpr double kFocal = 400.0;
constexpr double kCentreX = 319.5;
constexpr double kCentreY = 239.5;
constexpr Utime kStart = 1'000'000'000;
constexpr Utime kPicturePeriod = 50'000;
/// More than the CAMERA_INFO's patience of 1.2 s.
constexpr int kPicturesUntilFallback = 26;

/// A wall 8 m away with panels in front of it, all with a random pattern of patches of 6 cm.
class Scene {
 public:
  Scene() : pattern_(kCells * kCells) {
    std::uint32_t state = 1;
    for (double& cell : pattern_) {
      state = state * 1664525U + 1013904223U;
      cell = 30.0 + 200.0 * (state >> 24) / 255.0;
    }
  }

  /// Seen straight ahead from (x, 0, 0).
  cv::Mat picture(double x) const {
    cv::Mat grey(kHeight, kWidth, CV_8UC1);
    for (int v = 0; v < kHeight; ++v) {
      for (int u = 0; u < kWidth; ++u) {
        grey.at<std::uint8_t>(v, u) = shade(x, (u - kCentreX) / kFocal, (v - kCentreY) / kFocal);
      }
    }
    return grey;
  }

 private:
  struct Panel {
    double z, left, right, top, bottom;
  };

  std::uint8_t shade(double x, double dx, double dy) const {
    static constexpr std::array<Panel, 4> kPanels = {{{3.5, -1.6, -0.4, -0.8, 0.6},
                                                      {4.5, 0.2, 1.6, -0.4, 1.4},
                                                      {5.5, 1.0, 3.2, -2.4, -0.6},
                                                      {8.0, -1e9, 1e9, -1e9, 1e9}}};
    for (const Panel& panel : kPanels) {
      const double px = x + panel.z * dx;
      const double py = panel.z * dy;
      if (px >= panel.left && px <= panel.right && py >= panel.top && py <= panel.bottom) {
        return static_cast<std::uint8_t>(pattern(px + 31.0 * panel.z, py + 17.0 * panel.z));
      }
    }
    return 0;
  }

  double pattern(double x, double y) const {
    constexpr double kPatch = 0.06;
    const double column = std::floor(x / kPatch);
    const double row = std::floor(y / kPatch);
    const double right = x / kPatch - column;
    const double down = y / kPatch - row;
    const auto cell = [&](int i, int j) {
      const auto wrap = [](double value) {
        return static_cast<std::size_t>(static_cast<std::int64_t>(value) & (kCells - 1));
      };
      return pattern_[wrap(row + j) * kCells + wrap(column + i)];
    };
    return (1 - down) * ((1 - right) * cell(0, 0) + right * cell(1, 0)) +
           down * ((1 - right) * cell(0, 1) + right * cell(1, 1));
  }

  static constexpr int kCells = 256;
  std::vector<double> pattern_;
};

/// Pictures of a camera that moves sideways, 5 cm from one to the next; rendered once.
const cv::Mat& scenePicture(int number) {
  static const Scene scene;
  static std::map<int, cv::Mat> pictures;
  const auto [found, isNew] = pictures.try_emplace(number);
  if (isNew) {
    found->second = scene.picture(0.05 * number);
  }
  return found->second;
}

bot_core::image_t imageMessage(Utime utime, std::int32_t format, std::int32_t row_stride,
                               std::vector<std::uint8_t> data) {
  bot_core::image_t message;
  message.utime = utime;
  message.width = kWidth;
  message.height = kHeight;
  message.row_stride = row_stride;
  message.pixelformat = format;
  message.size = static_cast<std::int32_t>(data.size());
  message.data = std::move(data);
  message.nmetadata = 0;
  return message;
}

bot_core::image_t greyImage(Utime utime, const cv::Mat& grey) {
  return imageMessage(utime, lcm_io::kGrey, kWidth, {grey.datastart, grey.dataend});
}

bot_core::image_t jpegImage(Utime utime, const cv::Mat& grey) {
  std::vector<std::uint8_t> data;
  cv::imencode(".jpg", grey, data);
  return imageMessage(utime, lcm_io::kMjpg, 0, data);
}

class SlamMonoNodeTest : public testing::Test {
 protected:
  SlamMonoNodeTest() { restart(); }

  void restart(const std::filesystem::path& state_dir = {}) {
    node_.reset();
    hub_ = std::make_unique<lcm_io::ReplayHub>();
    now_ = kStart;
    hub_->advanceTo(now_);
    bus_ = &hub_->endpoint();
    node_ = slam_mono::makeNode({.bus = *bus_, .config = config_, .state_dir = state_dir});
    lcm_io::Bus& ears = hub_->endpoint();
    poses_.clear();
    features_.clear();
    maps_.clear();
    published_.clear();
    ears.subscribeAll([this](const lcm_io::RawMessage& raw) {
      published_.push_back(raw.data);
      if (raw.channel == lcm_io::channel::kMonoPose) {
        poses_.push_back(lcm_io::decode<mono_pose_t>(raw.data));
      } else if (raw.channel == lcm_io::channel::kMonoFeatures) {
        EXPECT_LE(raw.data.size(), 65'000U);
        features_.push_back(lcm_io::decode<rubble::mono_features_t>(raw.data));
      } else if (raw.channel == lcm_io::channel::kMonoMap) {
        EXPECT_LE(raw.data.size(), 61'000U);
        maps_.push_back(lcm_io::decode<rubble::mono_map_t>(raw.data));
      }
    });
  }

  template <typename Message>
  void feed(const char* channel, const Message& message) {
    hub_->advanceTo(now_);
    node_->advance(now_);
    hub_->feed({channel, now_, lcm_io::encode(message)});
    node_->advance(now_);
    hub_->deliverPending();
  }

  void calibrate(double focal = kFocal) {
    rubble::camera_info_t info;
    info.utime = now_;
    info.width = kWidth;
    info.height = kHeight;
    info.rate_hz = 20.0;
    info.fx = info.fy = focal;
    info.cx = kCentreX;
    info.cy = kCentreY;
    info.model = "pinhole";
    info.distortion = {0.0, 0.0, 0.0, 0.0};
    info.ndistortion = 4;
    feed(lcm_io::channel::kCameraInfo, info);
  }

  void show(const bot_core::image_t& image) { feed(lcm_io::channel::kCamera, image); }
  void walk(int pictures) {
    for (int i = 0; i < pictures; ++i) {
      now_ += kPicturePeriod;
      show(greyImage(now_, scenePicture(number_++ % 60)));
    }
  }

  std::int64_t refused(const char* channel = lcm_io::channel::kCamera) const {
    return bus_->received().at(channel).errors;
  }
  std::string why(const char* channel = lcm_io::channel::kCamera) const {
    return bus_->received().at(channel).last_error;
  }

  common::Config config_;
  std::unique_ptr<lcm_io::ReplayHub> hub_;
  lcm_io::Bus* bus_ = nullptr;
  std::unique_ptr<lcm_io::Node> node_;
  std::vector<mono_pose_t> poses_;
  std::vector<rubble::mono_features_t> features_;
  std::vector<rubble::mono_map_t> maps_;
  std::vector<lcm_io::Bytes> published_;
  Utime now_ = kStart;
  int number_ = 0;
};

TEST_F(SlamMonoNodeTest, FollowsTheCameraAndTellsItsMap) {
  EXPECT_EQ(node_->status().state, "waiting");
  calibrate();
  walk(40);
  node_->finish();
  hub_->deliverPending();
  ASSERT_EQ(poses_.size(), 40U) << "one for every picture";
  ASSERT_EQ(features_.size(), 40U);
  for (std::size_t i = 0; i < poses_.size(); ++i) {
    EXPECT_EQ(poses_[i].utime, features_[i].utime);
    EXPECT_GT(features_[i].n, 500);
  }
  ASSERT_EQ(poses_.back().state, mono_pose_t::STATE_TRACKING);
  EXPECT_EQ(node_->status().state, "tracking");
  // The way goes along x; its scale is the map's own.
  const auto first = std::find_if(poses_.begin(), poses_.end(),
                                  [](const auto& p) { return p.state == mono_pose_t::STATE_TRACKING; });
  const double dx = poses_.back().p_mono_camera[0] - first->p_mono_camera[0];
  EXPECT_GT(dx, 0.0);
  EXPECT_LT(std::abs(poses_.back().p_mono_camera[1] - first->p_mono_camera[1]), 0.05 * dx);

  std::set<std::int64_t> keyframes;
  std::set<std::int64_t> points;
  std::vector<Utime> frames;
  for (const rubble::mono_map_t& map : maps_) {
    for (const auto& k : map.keyframes) {
      keyframes.insert(k.id);
    }
    for (const auto& k : map.removed) {
      keyframes.erase(k.id);
    }
    for (const auto& p : map.points) {
      points.insert(p.id);
    }
    for (const auto& f : map.frames) {
      frames.push_back(f.utime);
    }
  }
  EXPECT_EQ(std::ssize(keyframes), node_->status().counters.at("keyframes"));
  EXPECT_EQ(std::ssize(keyframes), maps_.back().map_keyframes);
  EXPECT_GT(points.size(), 100U);
  EXPECT_GE(std::ssize(frames), node_->status().counters.at("tracked"));
  EXPECT_EQ(std::set<Utime>(frames.begin(), frames.end()).size(), frames.size()) << "once each";
}

TEST_F(SlamMonoNodeTest, AfterAKillNoKeyframeIdIsGivenTwice) {
  const test::TempDir state;
  config_.addOverride("slam_mono.checkpoint_period=5");
  std::map<std::int32_t, Utime> keyframes;
  const auto walkOn = [&] {
    restart(state.path());
    calibrate();
    now_ += common::kMicrosecondsPerSecond * static_cast<Utime>(keyframes.size());
    walk(50);
    for (const rubble::mono_map_t& map : maps_) {
      for (const auto& k : map.keyframes) {
        EXPECT_EQ(keyframes.try_emplace(k.id, k.utime).first->second, k.utime) << "keyframe " << k.id;
      }
    }
  };
  walkOn();
  const std::size_t before = keyframes.size();
  const std::int32_t newest = keyframes.rbegin()->first;
  ASSERT_GT(newest, 2) << "there are keyframes that the only checkpoint does not have";
  walkOn();
  EXPECT_GT(keyframes.size(), before);
  EXPECT_EQ(keyframes.begin()->first, 0) << "restored";
  EXPECT_GT(keyframes.rbegin()->first, newest);
}

TEST_F(SlamMonoNodeTest, TheSamePicturesGiveTheSameBytes) {
  calibrate();
  walk(30);
  const auto first = published_;
  restart();
  number_ = 0;
  calibrate();
  walk(30);
  EXPECT_TRUE(first == published_);
}

TEST_F(SlamMonoNodeTest, ReadsEveryPixelFormat) {
  calibrate();
  const cv::Mat& grey = scenePicture(0);
  show(greyImage(++now_, grey));
  std::vector<std::uint8_t> yuyv;
  std::vector<std::uint8_t> wide;
  constexpr int kPadding = 24;
  for (int v = 0; v < kHeight; ++v) {
    const std::uint8_t* row = grey.ptr<std::uint8_t>(v);
    for (int u = 0; u < kWidth; ++u) {
      yuyv.insert(yuyv.end(), {row[u], 128});
    }
    wide.insert(wide.end(), row, row + kWidth);
    wide.insert(wide.end(), kPadding, 77);
  }
  wide.resize(wide.size() - kPadding);
  show(imageMessage(++now_, lcm_io::kYuyv, 2 * kWidth, yuyv));
  show(imageMessage(++now_, lcm_io::kGrey, kWidth + kPadding, wide));
  show(jpegImage(++now_, grey));
  ASSERT_EQ(features_.size(), 4U);
  EXPECT_EQ(features_[1].descriptors, features_[0].descriptors);
  EXPECT_EQ(features_[2].descriptors, features_[0].descriptors);
  EXPECT_GT(features_[3].n, 500);
}

TEST_F(SlamMonoNodeTest, WithoutCameraInfoTheConfigurationsCalibrationIsTaken) {
  walk(3);
  EXPECT_EQ(poses_.size(), 3U);
  EXPECT_EQ(features_.size(), 3U) << "recognition need not wait";
  EXPECT_EQ(poses_.back().state, mono_pose_t::STATE_INITIALIZING);
  EXPECT_TRUE(std::isinf(poses_.back().covariance[0]));
  EXPECT_FALSE(node_->status().counters.contains("keyframes"));
  walk(kPicturesUntilFallback);
  EXPECT_TRUE(node_->status().counters.contains("keyframes"));
  EXPECT_EQ(poses_.size(), 3U + kPicturesUntilFallback);
  walk(20);
  EXPECT_EQ(poses_.back().state, mono_pose_t::STATE_TRACKING);
}

TEST_F(SlamMonoNodeTest, AConfiguredCalibrationOfAnotherSizeIsNotTaken) {
  config_.addOverride("robot.camera.width=752");
  restart();
  walk(2 * kPicturesUntilFallback);
  EXPECT_EQ(node_->status().state, "initializing");
  EXPECT_EQ(node_->status().level, lcm_io::NodeStatus::Level::kDegraded);
  EXPECT_NE(node_->status().detail.find("640 x 480"), std::string::npos) << node_->status().detail;
  calibrate();
  walk(10);
  EXPECT_NE(node_->status().level, lcm_io::NodeStatus::Level::kDegraded) << node_->status().detail;
}

TEST_F(SlamMonoNodeTest, AnotherCalibrationIsRefusedAndSaidForGood) {
  calibrate();
  calibrate();
  EXPECT_EQ(refused(lcm_io::channel::kCameraInfo), 0);
  walk(2);
  calibrate(kFocal + 1.0);
  EXPECT_EQ(refused(lcm_io::channel::kCameraInfo), 1);
  walk(2);
  EXPECT_EQ(node_->status().level, lcm_io::NodeStatus::Level::kDegraded);
  EXPECT_NE(node_->status().detail.find("CAMERA_INFO"), std::string::npos);
  EXPECT_EQ(poses_.size(), 4U);
}

TEST_F(SlamMonoNodeTest, ACalibrationThatIsNoneIsRefused) {
  calibrate(0.0);
  calibrate(-1.0);
  calibrate(std::nan(""));
  EXPECT_EQ(refused(lcm_io::channel::kCameraInfo), 3);
  calibrate();
  EXPECT_EQ(refused(lcm_io::channel::kCameraInfo), 3);
}

TEST_F(SlamMonoNodeTest, BadPicturesAreRefusedAndTheRestGoesOn) {
  calibrate();
  walk(40);
  ASSERT_EQ(poses_.back().state, mono_pose_t::STATE_TRACKING);
  const std::size_t good = published_.size();
  const auto expectRefused = [&](const bot_core::image_t& image, const std::string& reason) {
    const std::int64_t before = refused();
    const std::size_t poses = poses_.size();
    show(image);
    EXPECT_EQ(refused(), before + 1) << reason;
    EXPECT_NE(why().find(reason), std::string::npos) << why();
    EXPECT_EQ(poses_.size(), poses);
  };
  const cv::Mat& grey = scenePicture(40);
  const Utime last = now_;
  now_ += 1000;
  expectRefused(greyImage(last, grey), "not newer");
  expectRefused(greyImage(last - kPicturePeriod, grey), "not newer");

  auto image = greyImage(now_, grey);
  image.pixelformat = lcm_io::fourCc("H264");
  expectRefused(image, "pixel format");
  image = greyImage(now_, grey);
  image.width = 320;
  expectRefused(image, "calibration is for 640 x 480");
  image = greyImage(now_, grey);
  image.row_stride = kWidth - 1;
  expectRefused(image, "are no picture");
  image = greyImage(now_, grey);
  image.data.resize(image.data.size() / 2);
  image.size = static_cast<std::int32_t>(image.data.size());
  expectRefused(image, "are no picture");
  image.pixelformat = lcm_io::kYuyv;
  image.row_stride = 2 * kWidth;
  expectRefused(image, "are no picture");

  image = jpegImage(now_, grey);
  image.data.resize(image.data.size() / 2);
  image.size = static_cast<std::int32_t>(image.data.size());
  expectRefused(image, "cut off");
  image.data.assign(image.data.size(), 0x5a);
  expectRefused(image, "damaged");
  image.data.clear();
  image.size = 0;
  expectRefused(image, "damaged");
  expectRefused(jpegImage(now_, grey(cv::Rect(0, 0, 320, 240)).clone()), "320 x 240");
  EXPECT_EQ(published_.size(), good + 11) << "nothing but what was fed";

  walk(5);
  EXPECT_EQ(poses_.back().state, mono_pose_t::STATE_TRACKING);
}

TEST_F(SlamMonoNodeTest, BeforeTheCalibrationAnAbsurdSizeIsRefusedToo) {
  for (const int side : {0, -5, 63, 8193, 2'000'000'000}) {
    ++now_;
    auto image = greyImage(now_, scenePicture(0));
    image.width = side;
    show(image);
    image.width = kWidth;
    image.height = side;
    show(image);
  }
  EXPECT_EQ(refused(), 10);
  EXPECT_EQ(node_->status().state, "waiting");
}

}  // namespace
}  // namespace rubble
