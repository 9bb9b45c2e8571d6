#include "scene/signs.h"

#include <ZXing/BarcodeFormat.h>
#include <ZXing/BitMatrix.h>
#include <ZXing/CharacterSet.h>
#include <ZXing/MultiFormatWriter.h>
#include <apriltag/apriltag.h>
#include <apriltag/common/image_u8.h>
#include <apriltag/tagStandard41h12.h>
#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <memory>
#include <opencv2/imgproc.hpp>

#include "common/error.h"

namespace rubble::arena_sim {

namespace {

// Sqrt-encoded reflectance of print on paper.
constexpr std::uint8_t kPaper = 235;
constexpr std::uint8_t kInk = 40;

/// Modules of one texel each, enlarged without blur.
cv::Mat enlarge(const cv::Mat& modules, int pixels) {
  RUBBLE_CHECK(pixels > 0);
  const int whole = std::max(1, pixels / modules.cols) * modules.cols;
  cv::Mat scaled;
  cv::resize(modules, scaled, {whole, whole}, 0.0, 0.0, cv::INTER_NEAREST);
  cv::resize(scaled, scaled, {pixels, pixels}, 0.0, 0.0, cv::INTER_NEAREST);
  cv::cvtColor(scaled, scaled, cv::COLOR_GRAY2BGR);
  return scaled;
}

}  // namespace

cv::Mat drawQrCode(const std::string& text, int pixels) {
  constexpr int kQuietZone = 4;
  constexpr int kLevelM = 2;  // Of 0 .. 8, as MultiFormatWriter counts.
  try {
    const ZXing::BitMatrix code = ZXing::MultiFormatWriter(ZXing::BarcodeFormat::QRCode)
                                      .setMargin(kQuietZone)
                                      .setEccLevel(kLevelM)
                                      .setEncoding(ZXing::CharacterSet::UTF8)
                                      .encode(text, 0, 0);
    cv::Mat modules(code.height(), code.width(), CV_8U);
    for (int y = 0; y < modules.rows; ++y) {
      for (int x = 0; x < modules.cols; ++x) {
        modules.at<std::uint8_t>(y, x) = code.get(x, y) ? kInk : kPaper;
      }
    }
    return enlarge(modules, pixels);
  } catch (const std::exception& e) {
    throw common::Error(
        fmt::format("QR code of '{:.60}': {}; use another or a shorter text", text, e.what()));
  }
}

cv::Mat drawAprilTag(int id, int pixels) {
  const std::unique_ptr<apriltag_family_t, void (*)(apriltag_family_t*)> family(tagStandard41h12_create(),
                                                                                tagStandard41h12_destroy);
  if (id < 0 || id >= static_cast<int>(family->ncodes)) {
    throw common::Error(
        fmt::format("AprilTag {}: tagStandard41h12 has the numbers 0 to {}", id, family->ncodes - 1));
  }
  const std::unique_ptr<image_u8_t, void (*)(image_u8_t*)> tag(
      apriltag_to_image(family.get(), static_cast<std::uint32_t>(id)), image_u8_destroy);
  RUBBLE_CHECK(tag->width == static_cast<int>(kTagModules) - 2);
  cv::Mat modules(tag->height + 2, tag->width + 2, CV_8U, cv::Scalar::all(kPaper));
  for (int y = 0; y < tag->height; ++y) {
    for (int x = 0; x < tag->width; ++x) {
      modules.at<std::uint8_t>(y + 1, x + 1) = tag->buf[y * tag->stride + x] > 127 ? kPaper : kInk;
    }
  }
  return enlarge(modules, pixels);
}

}  // namespace rubble::arena_sim
