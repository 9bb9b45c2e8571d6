#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bot_core/image_t.hpp>
#include <bot_core/planar_lidar_t.hpp>
#include <cmath>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <rubble/camera_info_t.hpp>
#include <rubble/odometry_t.hpp>

#include "common/files.h"
#include "import_rosbag.h"
#include "log_content.h"
#include "picture.h"
#include "ros_bag_writer.h"
#include "support/error_text.h"
#include "support/temp_dir.h"

namespace rubble::tools {
namespace {

using test::errorOf;
using test::messagesOf;
using test::RosBagWriter;
using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class RosbagTest : public ::testing::Test {
 protected:
  std::filesystem::path bag() const { return dir_.path() / "run.bag"; }
  std::filesystem::path log() const { return dir_.path() / "run.lcm"; }
  void import(const RosbagTopics& topics = {}) const { importRosbag(bag(), log(), topics); }
  std::string importError(const RosbagTopics& topics = {}) const {
    return errorOf([&] { import(topics); });
  }
  std::vector<bot_core::image_t> pictures() const { return messagesOf<bot_core::image_t>(log(), "CAMERA"); }

  test::TempDir dir_;
};

class RosbagCompressionTest : public RosbagTest,
                              public ::testing::WithParamInterface<RosBagWriter::Compression> {};

TEST_P(RosbagCompressionTest, EveryKindOfMessage) {
  const float kInf = std::numeric_limits<float>::infinity();
  {
    RosBagWriter writer(bag(), GetParam());
    writer.scan("/scan", 10.0, {0.05F, 1.0F, 31.0F, std::nanf(""), 30.0F}, 0.1F, 30.0F);
    writer.odometry("/odom", 9.9, 1.0, 2.0, 0.5);  // Recorded late: it belongs before the scan.
    writer.image("/image", 10.1, "mono8", 4, 2, 5, {1, 2, 3, 4, 0, 5, 6, 7, 8, 0});
    writer.cameraInfo("/camera_info", 10.1, 100.0, "plumb_bob");
  }
  import();
  const auto events = test::eventsOf(log());
  ASSERT_EQ(events.size(), 4U);
  EXPECT_EQ(events[0].channel, "ODOMETRY");

  const auto scan = messagesOf<bot_core::planar_lidar_t>(log(), "SCAN").at(0);
  EXPECT_EQ(scan.utime, 10000000);
  EXPECT_FLOAT_EQ(scan.rad0, -1.5F);
  EXPECT_FLOAT_EQ(scan.radstep, 0.25F);
  EXPECT_THAT(scan.ranges, ElementsAre(kInf, 1.0F, kInf, kInf, 30.0F));
  EXPECT_EQ(scan.nintensities, 5);

  const auto odometry = messagesOf<rubble::odometry_t>(log(), "ODOMETRY").at(0);
  EXPECT_DOUBLE_EQ(odometry.p_odom_body[1], 2.0);
  EXPECT_NEAR(odometry.q_odom_body[0], std::cos(0.25), 1e-12);
  EXPECT_NEAR(odometry.q_odom_body[3], std::sin(0.25), 1e-12);

  const auto picture = pictures().at(0);
  EXPECT_EQ(picture.pixelformat, lcm_io::kGrey);
  EXPECT_EQ(picture.row_stride, 4);
  EXPECT_THAT(picture.data, ElementsAre(1, 2, 3, 4, 5, 6, 7, 8));

  const auto camera = messagesOf<rubble::camera_info_t>(log(), "CAMERA_INFO").at(0);
  EXPECT_EQ(camera.model, "pinhole");
  EXPECT_EQ(camera.width, 4);
  EXPECT_DOUBLE_EQ(camera.cx, 1.5);
  EXPECT_THAT(camera.distortion, ElementsAre(0.1, 0.2, 0.3, 0.4));
}

TEST_P(RosbagCompressionTest, NoByteThatIsWrongDoesMoreThanAnError) {
  {
    RosBagWriter writer(bag(), GetParam());
    writer.scan("/scan", 10.0, {1.0F, 2.0F}, 0.1F, 30.0F);
    writer.scan("/scan", 11.0, {1.0F, 2.0F}, 0.1F, 30.0F);
  }
  const auto content = common::readFile(bag());
  const std::string whole(content.begin(), content.end());
  // Much is padding or text.
  for (std::size_t i = 0; i < whole.size(); i += i % 4096 < 600 ? 13 : 101) {
    std::string damaged = whole;
    damaged[i] = i % 2 == 0 ? '\xff' : '\0';
    dir_.write("run.bag", damaged);
    EXPECT_THAT(importError(), AnyOf("(no error)", HasSubstr("run.bag: "))) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(All, RosbagCompressionTest,
                         ::testing::Values(RosBagWriter::Compression::kNone, RosBagWriter::Compression::kBz2,
                                           RosBagWriter::Compression::kLz4));

TEST_F(RosbagTest, EveryEncodingBecomesGrey) {
  struct Case {
    const char* encoding;
    std::uint32_t bytes_per_pixel;
    std::vector<std::uint8_t> pixel;
    int grey;
  };
  // Grey of pure red is 76, of pure blue 29 (ITU-R BT.601).
  const std::vector<Case> cases = {
      {"rgb8", 3, {255, 0, 0}, 76},     {"bgr8", 3, {255, 0, 0}, 29}, {"rgba8", 4, {255, 0, 0, 9}, 76},
      {"bgra8", 4, {255, 0, 0, 9}, 29}, {"mono16", 2, {0, 128}, 128}, {"yuv422", 2, {1, 77}, 77},
      {"yuv422_yuy2", 2, {77, 1}, 77},  {"bayer_rggb8", 1, {90}, 90},
  };
  for (const Case& c : cases) {
    std::vector<std::uint8_t> data;
    for (int i = 0; i < 4 * 4; ++i) {
      data.insert(data.end(), c.pixel.begin(), c.pixel.end());
    }
    {
      RosBagWriter writer(bag(), RosBagWriter::Compression::kNone);
      writer.image("/image", 1.0, c.encoding, 4, 4, 4 * c.bytes_per_pixel, data);
    }
    import();
    EXPECT_NEAR(pictures().at(0).data.at(5), c.grey, 1) << c.encoding;
  }
}

TEST_F(RosbagTest, BayerPatternsAreToldApart) {
  // Only the red sites are lit: grey is 0.299 of it everywhere that demosaicing is exact.
  for (const auto& [encoding, red_x, red_y] : std::vector<std::tuple<std::string, int, int>>{
           {"bayer_rggb8", 0, 0}, {"bayer_grbg8", 1, 0}, {"bayer_gbrg8", 0, 1}, {"bayer_bggr8", 1, 1}}) {
    std::vector<std::uint8_t> data(8 * 8, 0);
    for (int y = red_y; y < 8; y += 2) {
      for (int x = red_x; x < 8; x += 2) {
        data.at(static_cast<std::size_t>(8 * y + x)) = 200;
      }
    }
    {
      RosBagWriter writer(bag(), RosBagWriter::Compression::kNone);
      writer.image("/image", 1.0, encoding, 8, 8, 8, data);
    }
    import();
    EXPECT_NEAR(pictures().at(0).data.at(8 * 4 + 4), 60, 2) << encoding;
  }
}

TEST_F(RosbagTest, CompressedPicturesPassThrough) {
  std::vector<std::uint8_t> jpeg;
  ASSERT_TRUE(cv::imencode(".jpg", cv::Mat(2, 4, CV_8UC1, cv::Scalar(50)), jpeg));
  {
    RosBagWriter writer(bag(), RosBagWriter::Compression::kNone);
    writer.compressed("/image/compressed", 1.0, jpeg);
    writer.compressed("/image/compressed", 0.0, jpeg);  // No stamp: the time of recording.
  }
  import();
  EXPECT_EQ(pictures().at(0).data, jpeg);
  EXPECT_EQ(pictures().at(0).pixelformat, lcm_io::kMjpg);
  EXPECT_EQ(pictures().at(1).utime, 1000020000);

  {
    RosBagWriter writer(bag(), RosBagWriter::Compression::kNone);
    jpeg.resize(jpeg.size() / 2);
    writer.compressed("/image/compressed", 1.0, jpeg);
  }
  EXPECT_THAT(importError(),
              AllOf(HasSubstr("run.bag"), HasSubstr("/image/compressed"), HasSubstr("damaged")));
}

TEST_F(RosbagTest, SeveralTopicsNeedAChoice) {
  {
    RosBagWriter writer(bag(), RosBagWriter::Compression::kNone);
    writer.scan("/front", 1.0, {1.0F, 2.0F}, 0.1F, 30.0F);
    writer.scan("/rear", 1.0, {3.0F, 4.0F}, 0.1F, 30.0F);
  }
  EXPECT_THAT(importError(), AllOf(HasSubstr("--scan-topic"), HasSubstr("/front, /rear")));
  EXPECT_THAT(importError({.scan = "/side", .image = {}, .camera_info = {}, .odometry = {}}),
              AllOf(HasSubstr("/side"), HasSubstr("/front, /rear")));
  EXPECT_FALSE(std::filesystem::exists(log()));
  import({.scan = "/rear", .image = {}, .camera_info = {}, .odometry = {}});
  EXPECT_FLOAT_EQ(messagesOf<bot_core::planar_lidar_t>(log(), "SCAN").at(0).ranges.at(0), 3.0F);
}

TEST_F(RosbagTest, UncalibratedAndFisheyeCameras) {
  {
    RosBagWriter writer(bag(), RosBagWriter::Compression::kNone);
    writer.image("/image", 1.0, "mono8", 1, 1, 1, {1});
    writer.cameraInfo("/camera_info", 1.0, 0.0, "");
    writer.cameraInfo("/camera_info", 2.0, 50.0, "equidistant");
  }
  import();
  const auto cameras = messagesOf<rubble::camera_info_t>(log(), "CAMERA_INFO");
  ASSERT_EQ(cameras.size(), 1U);
  EXPECT_EQ(cameras[0].model, "fisheye");
}

TEST_F(RosbagTest, DamagedBagsGiveOneClearLine) {
  {
    RosBagWriter writer(bag(), RosBagWriter::Compression::kNone);
    for (int i = 0; i < 100; ++i) {
      writer.scan("/scan", 1.0 + i, std::vector<float>(500, 1.0F), 0.1F, 30.0F);
    }
  }
  std::filesystem::resize_file(bag(), std::filesystem::file_size(bag()) / 2);
  EXPECT_THAT(importError(), HasSubstr("run.bag: "));
  EXPECT_THAT(importError(), ::testing::Not(HasSubstr("\n")));
  dir_.write("run.bag", "#ROSBAG V2.0\n");
  EXPECT_THAT(importError(), HasSubstr("run.bag: "));
  dir_.write("run.bag", "nothing of the kind");
  EXPECT_THAT(importError(), HasSubstr("run.bag: not a bag"));
  dir_.write("run.bag", "");
  EXPECT_THAT(importError(), HasSubstr("run.bag: "));
  std::filesystem::remove(bag());
  EXPECT_THAT(importError(), HasSubstr("run.bag: "));
  { RosBagWriter writer(bag(), RosBagWriter::Compression::kNone); }
  EXPECT_THAT(importError(), HasSubstr("no LaserScan"));
  {
    RosBagWriter writer(bag(), RosBagWriter::Compression::kNone);
    writer.image("/image", 1.0, "32FC1", 1, 1, 4, {1, 2, 3, 4});
  }
  EXPECT_THAT(importError(), AllOf(HasSubstr("/image"), HasSubstr("32FC1")));
}

}  // namespace
}  // namespace rubble::tools
