#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bot_core/image_t.hpp>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <rubble/camera_info_t.hpp>
#include <rubble/ground_truth_t.hpp>
#include <string>

#include "common/files.h"
#include "export_tum.h"
#include "log_content.h"
#include "picture.h"
#include "picture_sequence.h"
#include "support/error_text.h"
#include "support/temp_dir.h"

namespace rubble::tools {
namespace {

using test::errorOf;
using test::messagesOf;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr int kWidth = 20;
constexpr int kHeight = 10;

cv::Mat pattern(int seed) {
  cv::Mat grey(kHeight, kWidth, CV_8UC1);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      grey.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>((seed * 31 + x * 7 + y * 13) % 256);
    }
  }
  return grey;
}

class SequenceTest : public ::testing::Test {
 protected:
  std::filesystem::path dir() const { return dir_.path(); }
  std::filesystem::path log() const { return dir() / "out.lcm"; }
  std::filesystem::path write(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories((dir() / name).parent_path());
    return dir_.write(name, text);
  }
  void writePicture(const std::string& name, int seed) const {
    std::filesystem::create_directories((dir() / name).parent_path());
    ASSERT_TRUE(cv::imwrite((dir() / name).string(), pattern(seed)));
  }
  void writeTum() const {
    write("rgb.txt", "# timestamp filename\n0.0 rgb/a.png\n0.1 rgb/b.jpg\n1.5 rgb/c.png\n");
    write("calib.txt",
          "# width height fps fx fy cx cy k1 k2 p1 p2\n20 10 30 15 16 9.5 4.5 0.1 0.2 0.3 0.4\n");
    write("groundtruth.txt", "0.5 1 2 3 0 0 0 1\n");
    writePicture("rgb/a.png", 1);
    writePicture("rgb/b.jpg", 2);
    writePicture("rgb/c.png", 3);
  }
  void importTum() const { writeSequence(readTumSequence(dir()), log()); }
  std::vector<bot_core::image_t> pictures() const { return messagesOf<bot_core::image_t>(log(), "CAMERA"); }
  std::vector<rubble::ground_truth_t> truth() const {
    return messagesOf<rubble::ground_truth_t>(log(), "GROUND_TRUTH");
  }
  std::vector<rubble::camera_info_t> infos() const {
    return messagesOf<rubble::camera_info_t>(log(), "CAMERA_INFO");
  }

  test::TempDir dir_;
};

TEST_F(SequenceTest, TumPicturesTruthAndCalibration) {
  writeTum();
  importTum();
  const auto images = pictures();
  ASSERT_EQ(images.size(), 3U);
  EXPECT_EQ(images[0].pixelformat, lcm_io::kGrey);
  EXPECT_EQ(images[0].row_stride, kWidth);
  const cv::Mat first = pattern(1);
  EXPECT_EQ(images[0].data, std::vector<std::uint8_t>(first.datastart, first.dataend));
  EXPECT_EQ(images[1].pixelformat, lcm_io::kMjpg);
  EXPECT_EQ(images[1].data, common::readFile(dir() / "rgb/b.jpg"));
  EXPECT_EQ(images[1].width, kWidth);
  EXPECT_EQ(images[1].row_stride, 0);
  EXPECT_EQ(images[2].utime, 1500000);

  const auto info = infos();
  ASSERT_EQ(info.size(), 2U);  // 5 Hz: with the first picture and the one 1.5 s later.
  EXPECT_EQ(info[0].model, "pinhole");
  EXPECT_DOUBLE_EQ(info[0].fy, 16.0);
  EXPECT_THAT(info[0].distortion, ElementsAre(0.1, 0.2, 0.3, 0.4));

  ASSERT_EQ(truth().size(), 1U);
  EXPECT_EQ(truth()[0].frame, "camera");
  EXPECT_DOUBLE_EQ(truth()[0].p_world_frame[2], 3.0);
}

TEST_F(SequenceTest, MissingAndDamagedPicturesAreNamed) {
  writeTum();
  const auto text = [&] { return errorOf([&] { importTum(); }); };
  const auto bytes = [&](const char* name) {
    const auto content = common::readFile(dir() / name);
    return std::string(content.begin(), content.end());
  };
  const std::string png = bytes("rgb/c.png");
  const std::string jpg = bytes("rgb/b.jpg");

  write("rgb/c.png", png.substr(0, png.size() - 20));
  EXPECT_THAT(text(), AllOf(HasSubstr("rgb/c.png"), HasSubstr("damaged")));
  std::string flipped = png;
  flipped[png.size() / 2] = static_cast<char>(flipped[png.size() / 2] ^ 0x10);
  write("rgb/c.png", flipped);
  EXPECT_THAT(text(), AllOf(HasSubstr("rgb/c.png"), HasSubstr("damaged")));
  write("rgb/c.png", "no picture");
  EXPECT_THAT(text(), AllOf(HasSubstr("rgb/c.png"), HasSubstr("no picture that can be decoded")));
  write("rgb/c.png", "");
  EXPECT_THAT(text(), HasSubstr("rgb/c.png"));
  std::filesystem::remove(dir() / "rgb/c.png");
  EXPECT_THAT(text(), AllOf(HasSubstr("rgb/c.png"), HasSubstr("cannot be read")));
  write("rgb/b.jpg", jpg.substr(0, jpg.size() * 2 / 3));
  EXPECT_THAT(text(), AllOf(HasSubstr("rgb/b.jpg"), HasSubstr("damaged")));
  ASSERT_TRUE(cv::imwrite((dir() / "rgb/a.png").string(), cv::Mat(5, 5, CV_8UC1, cv::Scalar(7))));
  EXPECT_THAT(text(), AllOf(HasSubstr("rgb/a.png"), HasSubstr("5x5"), HasSubstr("20x10")));
  EXPECT_FALSE(std::filesystem::exists(log()));
}

TEST_F(SequenceTest, APictureThatAnnouncesGigabytesIsRefusedUndecoded) {
  writeTum();
  const auto text = [&](const std::string& picture) {
    write("rgb/a.png", picture);
    return errorOf([&] { importTum(); });
  };
  EXPECT_THAT(text("P5\n30000 30000\n255\nfew"), AllOf(HasSubstr("rgb/a.png"), HasSubstr("no picture")));
  EXPECT_THAT(text("P2\n# x\n30000 30000 255 1 2"), AllOf(HasSubstr("rgb/a.png"), HasSubstr("no picture")));

  std::vector<std::uint8_t> bytes;
  ASSERT_TRUE(cv::imencode(".jpg", pattern(1), bytes));
  std::string jpeg(bytes.begin(), bytes.end());
  const auto header = jpeg.find("\xff\xc0");
  ASSERT_NE(header, std::string::npos);
  jpeg.replace(header + 5, 4, "\x7f\xff\x7f\xff");
  EXPECT_THAT(text(jpeg), AllOf(HasSubstr("rgb/a.png"), HasSubstr("32767 x 32767")));

  ASSERT_TRUE(cv::imencode(".png", pattern(1), bytes));
  std::fill_n(bytes.begin() + 18, 2, std::uint8_t{0x70});  // Of the width.
  std::fill_n(bytes.begin() + 22, 2, std::uint8_t{0x70});  // Of the height.
  const std::uint32_t crc = common::crc32(std::span(bytes).subspan(12, 17));
  for (std::size_t i = 0; i < 4; ++i) {
    bytes[29 + i] = static_cast<std::uint8_t>(crc >> (24 - 8 * i));
  }
  EXPECT_THAT(text({bytes.begin(), bytes.end()}), AllOf(HasSubstr("rgb/a.png"), HasSubstr("28784 x 28784")));
}

TEST_F(SequenceTest, BadListsAndCalibrationsAreNamed) {
  writeTum();
  write("calib.txt", "20 10 30 15 16 9.5\n");
  EXPECT_THAT(errorOf([&] { importTum(); }), AllOf(HasSubstr("calib.txt:1"), HasSubstr("cy")));
  write("calib.txt", "20 10 30 0 16 9.5 4.5 0 0 0 0\n");
  EXPECT_THAT(errorOf([&] { importTum(); }), HasSubstr("must be positive"));
  std::filesystem::remove(dir() / "calib.txt");
  EXPECT_THAT(errorOf([&] { importTum(); }), HasSubstr("calib.txt"));
  write("rgb.txt", "0.0 rgb/a.png\nsoon rgb/b.jpg\n");
  EXPECT_THAT(errorOf([&] { importTum(); }),
              AllOf(HasSubstr("rgb.txt:2"), HasSubstr("`soon` is no timestamp")));
  write("rgb.txt", "# nothing\n");
  write("calib.txt", "20 10 30 15 16 9.5 4.5 0 0 0 0\n");
  EXPECT_THAT(errorOf([&] { importTum(); }), HasSubstr("no pictures"));
}

TEST_F(SequenceTest, ExportTumAndImportAgain) {
  writeTum();
  importTum();
  exportTum(log(), dir() / "again");
  EXPECT_EQ(common::readFile(dir() / "again/rgb/0.100000.jpg"), common::readFile(dir() / "rgb/b.jpg"));
  writeSequence(readTumSequence(dir() / "again"), dir() / "again.lcm");
  const auto first = test::eventsOf(log());
  const auto second = test::eventsOf(dir() / "again.lcm");
  ASSERT_EQ(first.size(), second.size());
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].channel, second[i].channel);
    EXPECT_EQ(first[i].data, second[i].data);
  }
}

TEST_F(SequenceTest, ExportNeedsPictures) {
  lcm_io::LogWriter(dir() / "empty.lcm").close();
  EXPECT_THAT(errorOf([&] { exportTum(dir() / "empty.lcm", dir() / "out"); }), HasSubstr("no pictures"));
}

TEST_F(SequenceTest, CalibLineKeepsEveryModel) {
  for (const std::string line :
       {"20 10 30 15 16 9.5 4.5 0.1 0.2 0.3 0.4", "20 10 30 15 16 9.5 4.5 0.1 0.2 0.3 0.4 0.5",
        "20 10 30 15 16 9.5 4.5 0.1 0.2 0.3 0.4 fisheye"}) {
    EXPECT_EQ(calibLine(parseCalibLine(line)), line);
  }
  EXPECT_EQ(parseCalibLine("20 10 30 15 16 9.5 4.5 0.1 0.2 0.3 0.4 fisheye").model, "fisheye");
  EXPECT_THAT(errorOf([] { parseCalibLine("20 10 30 15 16 9.5 4.5 0.1 0.2 0.3 0.4 fishy"); }),
              HasSubstr("fishy"));
}

constexpr const char* kSensor = R"(%YAML:1.0
T_BS:
  cols: 4
  rows: 4
  data: [0.0, -1.0, 0.0, 0.5,
         1.0, 0.0, 0.0, 0.0,
         0.0, 0.0, 1.0, 0.0,
         0.0, 0.0, 0.0, 1.0]
rate_hz: 20
resolution: [20, 10]
camera_model: pinhole
intrinsics: [15, 16, 9.5, 4.5]
distortion_model: equidistant
distortion_coefficients: [0.1, 0.2, 0.3, 0.4]
)";

TEST_F(SequenceTest, EurocBodyAndCamera) {
  write("mav0/cam0/data.csv", "#timestamp [ns],filename\r\n1403715285262142976,1403715285262142976.png\r\n");
  write("mav0/cam0/sensor.yaml", kSensor);
  write("mav0/state_groundtruth_estimate0/data.csv",
        "#timestamp, p_RS_R_x [m]\n1403715285262142976,1,2,3,1,0,0,0,0,0,0,0,0,0,0,0,0\n");
  writePicture("mav0/cam0/data/1403715285262142976.png", 4);
  writeSequence(readEurocSequence(dir()), log());
  ASSERT_EQ(pictures().size(), 1U);
  EXPECT_EQ(pictures()[0].utime, 1403715285262143);
  ASSERT_EQ(infos().size(), 1U);
  EXPECT_EQ(infos()[0].model, "fisheye");
  EXPECT_DOUBLE_EQ(infos()[0].rate_hz, 20.0);
  ASSERT_EQ(truth().size(), 2U);
  EXPECT_EQ(truth()[0].frame, "camera");
  EXPECT_DOUBLE_EQ(truth()[0].p_world_frame[0], 1.5);
  EXPECT_NEAR(truth()[0].q_world_frame[3], std::sqrt(0.5), 1e-12);
  EXPECT_EQ(truth()[1].frame, "body");
  EXPECT_DOUBLE_EQ(truth()[1].p_world_frame[0], 1.0);

  write("mav0/cam0/sensor.yaml", "resolution: [20, 10]\n");
  EXPECT_THAT(errorOf([&] { readEurocSequence(dir()); }),
              AllOf(HasSubstr("sensor.yaml"), HasSubstr("rate_hz")));
}

TEST_F(SequenceTest, KittiPosesBesideTheSequences) {
  write("sequences/07/times.txt", "0.0e+00\n1.0e-01\n2.1e-01\n");
  write("sequences/07/calib.txt", "P0: 15 0 9.5 0 0 16 4.5 0 0 0 1 0\nP1: 1\n");
  write("poses/07.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0.5 0 1 0 0 0 0 1 1\n1 0 0 1 0 1 0 0 0 0 1 2\n");
  for (int i = 0; i < 3; ++i) {
    writePicture("sequences/07/image_0/00000" + std::to_string(i) + ".png", i);
  }
  writeSequence(readKittiSequence(dir() / "sequences/07"), log());
  ASSERT_EQ(pictures().size(), 3U);
  EXPECT_EQ(pictures()[2].utime, 210000);
  EXPECT_EQ(infos().at(0).width, kWidth);
  EXPECT_DOUBLE_EQ(infos().at(0).cy, 4.5);
  EXPECT_NEAR(infos().at(0).rate_hz, 1.0 / 0.11, 1e-9);
  ASSERT_EQ(truth().size(), 3U);
  EXPECT_DOUBLE_EQ(truth()[2].p_world_frame[2], 2.0);

  write("poses/07.txt", "1 0 0 0 0 1 0 0 0 0 1\n");
  EXPECT_THAT(errorOf([&] { readKittiSequence(dir() / "sequences/07"); }), HasSubstr("07.txt:1"));
}

}  // namespace
}  // namespace rubble::tools
