#include "notice_picture.h"

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace rubble::recognizer {

namespace {

const cv::Scalar kInk(40, 40, 255);
const cv::Scalar kPaper(255, 255, 255);

void writeName(cv::Mat& picture, const std::string& name, cv::Point at) {
  constexpr double kSize = 0.6;
  int below = 0;
  const cv::Size size = cv::getTextSize(name, cv::FONT_HERSHEY_SIMPLEX, kSize, 2, &below);
  at.x = std::clamp(at.x, 2, std::max(2, picture.cols - size.width - 2));
  at.y = std::clamp(at.y, size.height + 2, std::max(size.height + 2, picture.rows - below - 2));
  cv::putText(picture, name, at, cv::FONT_HERSHEY_SIMPLEX, kSize, kPaper, 4, cv::LINE_AA);
  cv::putText(picture, name, at, cv::FONT_HERSHEY_SIMPLEX, kSize, kInk, 2, cv::LINE_AA);
}

}  // namespace

std::vector<std::uint8_t> noticeJpeg(const cv::Mat& picture, std::span<const cv::Point2f, 4> quad,
                                     const std::string& name, std::size_t most_bytes) {
  cv::Mat shown = picture.clone();
  cv::Point2f centre(0.0F, 0.0F);
  for (const cv::Point2f& corner : quad) {
    centre += corner / 4.0F;
  }
  double radius = 8.0;
  for (const cv::Point2f& corner : quad) {
    radius = std::max(radius, cv::norm(corner - centre));
  }
  // A corner may lie far outside.
  radius = std::min(radius, static_cast<double>(std::max(shown.cols, shown.rows)));
  const cv::Point at(cv::saturate_cast<int>(centre.x), cv::saturate_cast<int>(centre.y));
  cv::circle(shown, at, cv::saturate_cast<int>(radius), kInk, 3, cv::LINE_AA);
  writeName(shown, name, at - cv::Point(0, cv::saturate_cast<int>(radius) + 6));

  std::vector<std::uint8_t> jpeg;
  for (int quality = 85;; quality -= 20) {
    cv::imencode(".jpg", shown, jpeg, {cv::IMWRITE_JPEG_QUALITY, quality});
    if (jpeg.size() <= most_bytes) {
      return jpeg;
    }
    if (quality < 45) {
      cv::resize(shown, shown, {}, 0.5, 0.5, cv::INTER_AREA);
      quality = 105;
    }
  }
}

}  // namespace rubble::recognizer
