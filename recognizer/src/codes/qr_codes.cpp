#include "codes/qr_codes.h"

#define ZX_USE_UTF8 1  // Texts as std::string.
#include <ZXing/ReadBarcode.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <utility>

namespace rubble::recognizer {

namespace {

/// `scale`: of this picture to that whose pixels are asked for.
std::vector<Code> readAt(const cv::Mat& grey, double scale) {
  // The library's searches for turned and for smaller codes are of other kinds than QR.
  static const auto kHints = ZXing::DecodeHints().setFormats(ZXing::BarcodeFormat::QRCode);
  const ZXing::ImageView view(grey.data, grey.cols, grey.rows, ZXing::ImageFormat::Lum,
                              static_cast<int>(grey.step));
  std::vector<Code> codes;
  for (const ZXing::Result& result : ZXing::ReadBarcodes(view, kHints)) {
    Code code{"qr", result.text(), {}};
    for (std::size_t i = 0; i < code.quad.size(); ++i) {
      // Whole pixels: of the pixel that a corner lies in.
      const ZXing::PointI corner = result.position()[static_cast<int>(i)];
      code.quad[i] = cv::Point2d((corner.x + 0.5) / scale - 0.5, (corner.y + 0.5) / scale - 0.5);
    }
    codes.push_back(std::move(code));
  }
  return codes;
}

/// Small modules blur into each other in a picture; sharpened, each keeps its side of the threshold.
cv::Mat sharpenAndEnlarge(const cv::Mat& grey, double enlarge) {
  constexpr double kBlur = 0.7;  // pixels, 1 sigma
  constexpr double kStrength = 2.0;
  cv::Mat blurred;
  cv::GaussianBlur(grey, blurred, {}, kBlur);
  cv::Mat sharp;
  cv::addWeighted(grey, 1.0 + kStrength, blurred, -kStrength, 0.0, sharp);
  cv::Mat enlarged;
  cv::resize(sharp, enlarged, {}, enlarge, enlarge, cv::INTER_CUBIC);
  return enlarged;
}

cv::Point2f centreOf(const Code& code) {
  return 0.25F * (code.quad[0] + code.quad[1] + code.quad[2] + code.quad[3]);
}

bool areSame(const Code& a, const Code& b) {
  const cv::Rect2f box = cv::boundingRect(std::vector<cv::Point2f>(a.quad.begin(), a.quad.end()));
  return a.text == b.text && box.contains(centreOf(b));
}

}  // namespace

void readQrCodes(const cv::Mat& grey, double enlarge, std::vector<Code>& codes) {
  std::vector<Code> found = readAt(grey, 1.0);
  if (enlarge > 1.0) {
    for (Code& code : readAt(sharpenAndEnlarge(grey, enlarge), enlarge)) {
      if (std::none_of(found.begin(), found.end(), [&](const Code& known) { return areSame(known, code); })) {
        found.push_back(std::move(code));
      }
    }
  }
  std::move(found.begin(), found.end(), std::back_inserter(codes));
}

}  // namespace rubble::recognizer
