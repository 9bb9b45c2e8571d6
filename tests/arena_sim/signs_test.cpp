#include "scene/signs.h"

#define ZX_USE_UTF8 1  // Texts as std::string.
#include <ZXing/ReadBarcode.h>
#include <apriltag/apriltag.h>
#include <apriltag/tagStandard41h12.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "support/error_text.h"

namespace rubble::arena_sim {
namespace {

const cv::Scalar kBackground(100, 140, 160);

bool areEqual(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && cv::norm(a, b, cv::NORM_INF) == 0.0;
}

cv::Mat greyOf(const cv::Mat& picture) {
  cv::Mat grey;
  cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
  return grey;
}

using Corners = std::vector<cv::Point2f>;

struct View {
  cv::Mat grey;
  cv::Mat H;  // View from picture.
};

/// The picture as a camera sees it from the side, about 100 pixels wide.
View seenFromTheSide(const cv::Mat& picture) {
  const auto edge = static_cast<float>(picture.cols);
  const Corners from{{0.0F, 0.0F}, {edge, 0.0F}, {edge, edge}, {0.0F, edge}};
  // At four times the size, then averaged, as pixels average light.
  const Corners to{{160.0F, 120.0F}, {560.0F, 180.0F}, {550.0F, 520.0F}, {150.0F, 570.0F}};
  View view;
  view.H = cv::getPerspectiveTransform(from, to);
  cv::Mat large;
  cv::warpPerspective(greyOf(picture), large, view.H, {720, 720}, cv::INTER_AREA, cv::BORDER_CONSTANT,
                      cv::Scalar::all(150));
  cv::resize(large, view.grey, {180, 180}, 0.0, 0.0, cv::INTER_AREA);
  const cv::Mat shrink = (cv::Mat_<double>(3, 3) << 0.25, 0.0, 0.0, 0.0, 0.25, 0.0, 0.0, 0.0, 1.0);
  view.H = shrink * view.H;
  return view;
}

std::string readQr(const cv::Mat& grey) {
  const ZXing::ImageView image(grey.data, grey.cols, grey.rows, ZXing::ImageFormat::Lum,
                               static_cast<int>(grey.step));
  return ZXing::ReadBarcode(image, ZXing::DecodeHints().setFormats(ZXing::BarcodeFormat::QRCode)).text();
}

class TagDetector {
 public:
  TagDetector() { apriltag_detector_add_family(detector_.get(), family_.get()); }

  struct Tag {
    int id = -1;
    Corners corners;
  };

  std::vector<Tag> find(const cv::Mat& grey) {
    image_u8_t image{grey.cols, grey.rows, static_cast<int>(grey.step), grey.data};
    detector_->quad_decimate = 1.0F;
    zarray_t* found = apriltag_detector_detect(detector_.get(), &image);
    std::vector<Tag> tags;
    for (int i = 0; i < zarray_size(found); ++i) {
      apriltag_detection_t* detection = nullptr;
      zarray_get(found, i, &detection);
      Tag tag{detection->id, {}};
      for (const auto& p : detection->p) {
        tag.corners.emplace_back(static_cast<float>(p[0]), static_cast<float>(p[1]));
      }
      tags.push_back(tag);
    }
    apriltag_detections_destroy(found);
    return tags;
  }

 private:
  std::unique_ptr<apriltag_family_t, void (*)(apriltag_family_t*)> family_{tagStandard41h12_create(),
                                                                           tagStandard41h12_destroy};
  std::unique_ptr<apriltag_detector_t, void (*)(apriltag_detector_t*)> detector_{apriltag_detector_create(),
                                                                                 apriltag_detector_destroy};
};

/// How far the worst of the expected corners is from the tag's.
float worstCorner(const Corners& expected, const Corners& found) {
  float worst = 0.0F;
  for (const cv::Point2f& p : expected) {
    float nearest = 1e9F;
    for (const cv::Point2f& q : found) {
      nearest = std::min(nearest, std::hypot(p.x - q.x, p.y - q.y));
    }
    worst = std::max(worst, nearest);
  }
  return worst;
}

Corners tagCorners(int pixels) {
  const auto low = static_cast<float>(0.5 * (1.0 - kTagShare) * pixels);
  const auto high = static_cast<float>(pixels) - low;
  return {{low, low}, {high, low}, {high, high}, {low, high}};
}

TEST(Signs, TagHasTheLibrarysMeasures) {
  const std::unique_ptr<apriltag_family_t, void (*)(apriltag_family_t*)> family(tagStandard41h12_create(),
                                                                                tagStandard41h12_destroy);
  EXPECT_EQ(kTagModules, family->total_width + 2);
  EXPECT_EQ(kTagShare, family->width_at_border / kTagModules);
}

TEST(Signs, TagIsDetectedWhereItsShareSays) {
  TagDetector detector;
  for (const int id : {0, 17, 586}) {
    const cv::Mat picture = drawAprilTag(id, 440);
    const auto front = detector.find(greyOf(picture));
    ASSERT_EQ(front.size(), 1U) << id;
    EXPECT_EQ(front[0].id, id);
    EXPECT_LT(worstCorner(tagCorners(440), front[0].corners), 0.5F);

    const View view = seenFromTheSide(picture);
    const auto side = detector.find(view.grey);
    ASSERT_EQ(side.size(), 1U) << id;
    EXPECT_EQ(side[0].id, id);
    Corners expected;
    cv::perspectiveTransform(tagCorners(440), expected, view.H);
    EXPECT_LT(worstCorner(expected, side[0].corners), 0.5F);
  }
}

TEST(Signs, QrCodeIsRead) {
  for (const std::string text : {"hazard_12", "Rubble 2026: victim 3 behind the stairs"}) {
    for (const int pixels : {200, 333}) {
      const cv::Mat picture = drawQrCode(text, pixels);
      EXPECT_EQ(picture.size(), cv::Size(pixels, pixels));
      EXPECT_EQ(readQr(greyOf(picture)), text) << pixels;
    }
  }
  // Long enough for a code with the alignment mark by which readers undo perspective.
  const std::string text = "hazard_12 explosive";
  EXPECT_EQ(readQr(seenFromTheSide(drawQrCode(text, 400)).grey), text);
}

TEST(Signs, LabelsDifferAndFillADiamond) {
  constexpr int kPixels = 96;
  std::vector<cv::Mat> labels;
  for (const std::string_view name : hazardClasses()) {
    labels.push_back(drawHazardLabel(name, kPixels, kBackground));
    const cv::Mat& label = labels.back();
    ASSERT_EQ(label.size(), cv::Size(kPixels, kPixels));
    for (const cv::Point corner : {cv::Point(3, 3), cv::Point(92, 3), cv::Point(3, 92), cv::Point(92, 92)}) {
      EXPECT_EQ(cv::Scalar(label.at<cv::Vec3b>(corner)), kBackground) << name;
    }
    // Nearly to the tips of the diamond there is paint.
    for (const cv::Point tip : {cv::Point(48, 4), cv::Point(48, 91), cv::Point(4, 47), cv::Point(91, 47)}) {
      EXPECT_GT(cv::norm(cv::Scalar(label.at<cv::Vec3b>(tip)) - kBackground), 20.0) << name;
    }
    EXPECT_TRUE(areEqual(label, drawHazardLabel(name, kPixels, kBackground)));
  }
  EXPECT_EQ(labels.size(), 12U);
  for (std::size_t i = 0; i < labels.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      EXPECT_GT(cv::norm(labels[i], labels[j], cv::NORM_L1) / (3.0 * kPixels * kPixels), 2.5)
          << i << ' ' << j;
    }
  }
}

TEST(Signs, PostersDiffer) {
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    const cv::Mat poster = drawPoster(seed, 120, 160);
    EXPECT_EQ(poster.size(), cv::Size(120, 160));
    EXPECT_TRUE(areEqual(poster, drawPoster(seed, 120, 160)));
    EXPECT_FALSE(areEqual(poster, drawPoster(seed + 1, 120, 160)));
  }
  EXPECT_EQ(drawPoster(1, 7, 5).size(), cv::Size(7, 5));
}

TEST(Signs, BadInputIsNamed) {
  const std::string label = test::errorOf([] { drawHazardLabel("posion", 50, kBackground); });
  EXPECT_NE(label.find("'posion'"), std::string::npos) << label;
  EXPECT_NE(label.find("poison"), std::string::npos) << label;
  EXPECT_NE(test::errorOf([] { drawAprilTag(100000, 50); }).find("100000"), std::string::npos);
  EXPECT_NE(test::errorOf([] { drawQrCode(std::string(5000, 'x'), 50); }).find("shorter"), std::string::npos);
}

}  // namespace
}  // namespace rubble::arena_sim
