#include "contact_sheet.h"

#include <fmt/format.h>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "common/error.h"

namespace rubble::arena_sim {

ContactSheet::ContactSheet(double duration_s)
    : duration_s_(duration_s), sheet_(kRows * kHeight, kColumns * kWidth, CV_8UC3, cv::Scalar::all(0)) {}

void ContactSheet::add(double seconds, const cv::Mat& bgr) {
  constexpr int kPictures = kColumns * kRows;
  if (pictures_ == kPictures || seconds < duration_s_ * pictures_ / kPictures) {
    return;
  }
  cv::Mat cell = sheet_({pictures_ % kColumns * kWidth, pictures_ / kColumns * kHeight, kWidth, kHeight});
  cv::resize(bgr, cell, cell.size(), 0.0, 0.0, cv::INTER_AREA);
  cv::putText(cell, fmt::format("{:.0f} s", seconds), {6, kHeight - 8}, cv::FONT_HERSHEY_SIMPLEX, 0.45,
              {255, 255, 255}, 1, cv::LINE_AA);
  ++pictures_;
}

void ContactSheet::write(const std::filesystem::path& path) const {
  if (!cv::imwrite(path.string(), sheet_)) {
    throw common::Error(fmt::format("{}: picture cannot be written", path.string()));
  }
}

}  // namespace rubble::arena_sim
