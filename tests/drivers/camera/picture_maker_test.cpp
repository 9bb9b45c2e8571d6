#include "picture_maker.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "lcm_io/picture_decoder.h"
#include "lcm_io/pixel_format.h"
#include "pictures.h"

namespace rubble::camera {
namespace {

constexpr std::size_t kPadding = 20;

/// Largest difference of a colour anywhere.
double difference(const cv::Mat& a, const cv::Mat& b) { return cv::norm(a, b, cv::NORM_INF); }

/// A device's rows as a message, for the decoder as an oracle.
bot_core::image_t rawPicture(std::int32_t fourcc, std::size_t row, const std::vector<std::uint8_t>& bytes) {
  bot_core::image_t raw;
  raw.width = kWidth;
  raw.height = kHeight;
  raw.row_stride = static_cast<std::int32_t>(row);
  raw.pixelformat = fourcc;
  raw.data = bytes;
  return raw;
}

TEST(PictureMaker, MjpgPassesUntouched) {
  PictureMaker maker({}, {lcm_io::kMjpg, kWidth, kHeight, 0});
  const auto jpeg = jpegPicture();
  bot_core::image_t picture;
  ASSERT_TRUE(maker.make(jpeg, picture));
  EXPECT_EQ(picture.data, jpeg);
  EXPECT_EQ(picture.size, static_cast<int>(jpeg.size()));
  EXPECT_EQ(picture.pixelformat, lcm_io::kMjpg);
  EXPECT_EQ(picture.width, kWidth);
  EXPECT_EQ(picture.height, kHeight);
  EXPECT_EQ(picture.row_stride, 0);
}

TEST(PictureMaker, RefusesJpegThatIsCutOffOrOfAnotherSize) {
  PictureMaker maker({}, {lcm_io::kMjpg, kWidth, kHeight, 0});
  const auto jpeg = jpegPicture();
  bot_core::image_t picture;
  EXPECT_FALSE(maker.make({}, picture));
  EXPECT_FALSE(maker.make(lcm_io::ByteView(jpeg).first(jpeg.size() / 2), picture));
  PictureMaker other({}, {lcm_io::kMjpg, 2 * kWidth, kHeight, 0});
  EXPECT_FALSE(other.make(jpeg, picture));
}

TEST(PictureMaker, LeavesOutWhatCamerasFillTheirBuffersUpWith) {
  PictureMaker maker({}, {lcm_io::kMjpg, kWidth, kHeight, 0});
  const auto jpeg = jpegPicture();
  auto filled = jpeg;
  filled.resize(jpeg.size() + 100);
  bot_core::image_t picture;
  ASSERT_TRUE(maker.make(filled, picture));
  EXPECT_EQ(picture.data, jpeg);
}

TEST(PictureMaker, YuyvBecomesJpegOfTheSameColours) {
  for (const std::size_t row : {2 * kWidth + kPadding, std::size_t{2 * kWidth}}) {
    CameraConfig config;
    config.jpeg_quality = 95;
    PictureMaker maker(config, {lcm_io::kYuyv, kWidth, kHeight, row});
    const auto yuyv = yuyvPicture(row);
    bot_core::image_t picture;
    ASSERT_TRUE(maker.make(yuyv, picture));
    EXPECT_EQ(picture.pixelformat, lcm_io::kMjpg);
    EXPECT_LE(
        difference(lcm_io::decodeGrey(picture), lcm_io::decodeGrey(rawPicture(lcm_io::kYuyv, row, yuyv))),
        3.0);
    // JPEG's YCbCr has full range, V4L2's may have less: hue agrees, contrast not quite.
    const cv::Scalar mean = cv::mean(lcm_io::decodeColour(picture));
    EXPECT_GT(mean[2], mean[0]) << "more red than blue";
    EXPECT_FALSE(maker.make(lcm_io::ByteView(yuyv).first(yuyv.size() - 1), picture)) << "cut off";
  }
}

TEST(PictureMaker, GreyBecomesJpeg) {
  const auto grey = greyPicture(kWidth + kPadding);
  PictureMaker maker({}, {lcm_io::kGrey, kWidth, kHeight, kWidth + kPadding});
  bot_core::image_t picture;
  ASSERT_TRUE(maker.make(grey, picture));
  EXPECT_LE(difference(lcm_io::decodeGrey(picture),
                       lcm_io::decodeGrey(rawPicture(lcm_io::kGrey, kWidth + kPadding, grey))),
            6.0);
}

TEST(PictureMaker, RawGreyIsTheBrightnessWithoutGaps) {
  CameraConfig config;
  config.wire = "grey";
  bot_core::image_t picture;
  PictureMaker of_yuyv(config, {lcm_io::kYuyv, kWidth, kHeight, 2 * kWidth + kPadding});
  ASSERT_TRUE(of_yuyv.make(yuyvPicture(2 * kWidth + kPadding), picture));
  EXPECT_EQ(picture.data, greyPicture());
  EXPECT_EQ(picture.pixelformat, lcm_io::kGrey);
  EXPECT_EQ(picture.row_stride, kWidth);
  PictureMaker of_grey(config, {lcm_io::kGrey, kWidth, kHeight, kWidth + kPadding});
  ASSERT_TRUE(of_grey.make(greyPicture(kWidth + kPadding), picture));
  EXPECT_EQ(picture.data, greyPicture());
}

}  // namespace
}  // namespace rubble::camera
