#include "recognizer/code_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "scene/signs.h"
#include "support/error_text.h"

namespace rubble::recognizer {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

using Quad = std::array<cv::Point2f, 4>;

constexpr char kText[] = "room-73 fire exit";
constexpr double kQrModules = 33.0;  // Of the picture: version 2 and its quiet zone.

cv::Mat greyOf(const cv::Mat& picture) {
  cv::Mat grey;
  cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
  return grey;
}

/// The outline of a square picture's code, which has `margin` modules of `modules` on every side.
Quad outline(double pixels, double margin, double modules) {
  const auto low = static_cast<float>(pixels * margin / modules - 0.5);
  const auto high = static_cast<float>(pixels - pixels * margin / modules - 0.5);
  return {{{low, low}, {high, low}, {high, high}, {low, high}}};
}

Quad qrOutline(double pixels) { return outline(pixels, 4.0, kQrModules); }
Quad tagOutline(double pixels) { return outline(pixels, 1.0, arena_sim::kTagModules); }

/// What a camera sees of a printed code.
struct View {
  cv::Mat grey = cv::Mat(240, 320, CV_8UC1, cv::Scalar(130));
  cv::Mat H;  // View from picture.

  /// Turned by `angle` about the view's middle, so large (pixels), nearer on its right side.
  View(const cv::Mat& picture, double angle, double size) {
    const double edge = picture.cols - 0.5;
    const std::vector<cv::Point2f> from = {
        {-0.5F, -0.5F}, cv::Point2d(edge, -0.5), cv::Point2d(edge, edge), cv::Point2d(-0.5, edge)};
    std::vector<cv::Point2f> to;
    for (const cv::Point2d& corner : {cv::Point2d(-0.5, -0.45), {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.45}}) {
      const cv::Point2d p = size * corner;
      to.emplace_back(cv::Point2d(159.6 + std::cos(angle) * p.x - std::sin(angle) * p.y,
                                  119.8 + std::sin(angle) * p.x + std::cos(angle) * p.y));
    }
    H = cv::getPerspectiveTransform(from, to);
    // At four times the size, then averaged, as pixels average light.
    const cv::Mat enlarge = (cv::Mat_<double>(3, 3) << 4, 0, 1.5, 0, 4, 1.5, 0, 0, 1);
    cv::Mat large;
    cv::warpPerspective(greyOf(picture), large, enlarge * H, grey.size() * 4, cv::INTER_LINEAR,
                        cv::BORDER_CONSTANT, cv::Scalar(130));
    cv::resize(large, grey, grey.size(), 0.0, 0.0, cv::INTER_AREA);
  }

  void addNoise(double sigma) {
    cv::Mat noise(grey.size(), CV_16SC1);
    cv::RNG(3).fill(noise, cv::RNG::NORMAL, 0, sigma);
    cv::add(grey, noise, grey, cv::noArray(), CV_8U);
  }

  double error(const Quad& expected, const Quad& found) const {
    std::vector<cv::Point2f> seen;
    cv::perspectiveTransform(std::vector<cv::Point2f>(expected.begin(), expected.end()), seen, H);
    double worst = 0.0;
    for (std::size_t i = 0; i < seen.size(); ++i) {
      worst = std::max(worst, cv::norm(seen[i] - found[i]));
    }
    return worst;
  }
};

TEST(CodeReaderTest, QrCodesTurnedAndNoisy) {
  CodeReader reader;
  const cv::Mat picture = arena_sim::drawQrCode(kText, 400);
  for (int degrees = 0; degrees < 360; degrees += 30) {
    View view(picture, degrees / 180.0 * std::numbers::pi, 130.0);
    view.addNoise(8.0);
    const auto codes = reader.read(view.grey);
    ASSERT_EQ(codes.size(), 1U) << degrees;
    EXPECT_EQ(codes[0].kind, "qr");
    EXPECT_EQ(codes[0].text, kText);
    EXPECT_LT(view.error(qrOutline(400), codes[0].quad), 2.0) << degrees;
  }
}

TEST(CodeReaderTest, TagsTurnedAndNoisy) {
  CodeReader reader;
  const cv::Mat picture = arena_sim::drawAprilTag(1460, 440);
  for (int degrees = 0; degrees < 360; degrees += 30) {
    View view(picture, degrees / 180.0 * std::numbers::pi, 70.0);
    view.addNoise(8.0);
    const auto codes = reader.read(view.grey);
    ASSERT_EQ(codes.size(), 1U) << degrees;
    EXPECT_EQ(codes[0].kind, "apriltag");
    EXPECT_EQ(codes[0].text, "1460");
    EXPECT_LT(view.error(tagOutline(440), codes[0].quad), 1.0) << degrees;
  }
}

TEST(CodeReaderTest, ReadsSmallModules) {
  CodeReader reader;
  const cv::Mat qr = arena_sim::drawQrCode(kText, 660);
  const cv::Mat tag = arena_sim::drawAprilTag(7, 660);
  for (int degrees = 0; degrees < 90; degrees += 15) {
    const double angle = degrees / 180.0 * std::numbers::pi;
    EXPECT_EQ(reader.read(View(qr, angle, 1.6 * kQrModules).grey).size(), 1U) << degrees;
    EXPECT_EQ(reader.read(View(tag, angle, 2.6 * arena_sim::kTagModules).grey).size(), 1U) << degrees;
  }
}

TEST(CodeReaderTest, AllCodesOfAPicture) {
  cv::Mat picture(400, 600, CV_8UC1, cv::Scalar(180));
  const auto put = [&](const cv::Mat& code, int x, int y) {
    greyOf(code).copyTo(picture(cv::Rect(x, y, code.cols, code.rows)));
  };
  put(arena_sim::drawQrCode("one", 160), 10, 20);
  put(arena_sim::drawQrCode("two", 160), 230, 200);
  put(arena_sim::drawQrCode("one", 150), 430, 20);
  put(arena_sim::drawAprilTag(3, 110), 20, 250);
  put(arena_sim::drawAprilTag(4, 110), 450, 250);
  std::vector<std::string> texts;
  for (const Code& code : CodeReader().read(picture)) {
    texts.push_back(code.text);
  }
  EXPECT_THAT(texts, UnorderedElementsAre("one", "two", "one", "3", "4"));
}

TEST(CodeReaderTest, OnlyWhatIsAskedFor) {
  const cv::Mat qr = greyOf(arena_sim::drawQrCode(kText, 200));
  const cv::Mat tag = greyOf(arena_sim::drawAprilTag(5, 200));
  CodeReader only_tags({.qr = false});
  EXPECT_THAT(only_tags.read(qr), IsEmpty());
  EXPECT_EQ(only_tags.read(tag).size(), 1U);
  CodeReader only_qr({.apriltag = false});
  EXPECT_EQ(only_qr.read(qr).size(), 1U);
  EXPECT_THAT(only_qr.read(tag), IsEmpty());
}

TEST(CodeReaderTest, PartOfAPictureIsAPicture) {
  cv::Mat picture(300, 300, CV_8UC1, cv::Scalar(180));
  const cv::Rect part(40, 60, 200, 200);
  greyOf(arena_sim::drawQrCode(kText, 200)).copyTo(picture(part));
  CodeReader reader;
  EXPECT_EQ(reader.read(picture(part)).size(), 1U);
  CodeReader moved = std::move(reader);
  EXPECT_EQ(moved.read(picture(part)).size(), 1U);
}

TEST(CodeReaderTest, GarbageHoldsNoCodes) {
  CodeReader reader;
  cv::RNG random(5);
  for (const cv::Size size : {cv::Size(1, 1), cv::Size(8, 300), cv::Size(9, 9), cv::Size(300, 9),
                              cv::Size(17, 31), cv::Size(640, 480)}) {
    cv::Mat noise(size, CV_8UC1);
    random.fill(noise, cv::RNG::UNIFORM, 0, 256);
    EXPECT_THAT(reader.read(noise), IsEmpty()) << size;
    EXPECT_THAT(reader.read(cv::Mat(size, CV_8UC1, cv::Scalar(0))), IsEmpty()) << size;
  }
  EXPECT_THAT(reader.read(cv::Mat()), IsEmpty());
}

TEST(CodeReaderTest, OtherPicturesAreErrors) {
  CodeReader reader;
  EXPECT_THAT(test::errorOf([&] { reader.read(cv::Mat(10, 10, CV_8UC3)); }), HasSubstr("8UC1"));
  EXPECT_THAT(test::errorOf([&] { reader.read(cv::Mat(10, 10, CV_16UC1)); }), HasSubstr("8UC1"));
  EXPECT_THAT(test::errorOf([&] { reader.read(cv::Mat(1, CodeReader::kLargestSide + 1, CV_8UC1)); }),
              HasSubstr("too large"));
}

TEST(CodeReaderTest, ConfigurationIsChecked) {
  common::Config config;
  config.addOverride("recognizer.tag_decimate=2");
  EXPECT_EQ(config.read<CodeConfig>("recognizer").tag_decimate, 2.0);
  config.addOverride("recognizer.qr_enlarge=0.5");
  EXPECT_THAT(test::errorOf([&] { config.read<CodeConfig>("recognizer"); }), HasSubstr("qr_enlarge"));
}

}  // namespace
}  // namespace rubble::recognizer
