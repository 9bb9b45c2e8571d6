#include "recognizer/code_reader.h"

#include <fmt/format.h>

#include <algorithm>

#include "codes/apriltags.h"
#include "codes/qr_codes.h"
#include "common/error.h"

namespace rubble::recognizer {

void visit(common::ConfigSection& section, CodeConfig& config) {
  section.flag("qr", config.qr, "read QR codes");
  section.number("qr_enlarge", config.qr_enlarge, "", 1.0, 4.0,
                 "QR codes are looked for in a sharpened picture so many times larger, too: reads modules of "
                 "1.3 to 2 pixels; 1: not");
  section.flag("apriltag", config.apriltag, "read AprilTags of the family Standard41h12");
  section.number(
      "tag_decimate", config.tag_decimate, "", 1.0, 4.0,
      "AprilTags are looked for in a picture so many times smaller: faster, and small ones are missed");
}

CodeReader::CodeReader(const CodeConfig& config)
    : config_(config), tags_(config.apriltag ? std::make_unique<Tags>(config.tag_decimate) : nullptr) {}

CodeReader::~CodeReader() = default;
CodeReader::CodeReader(CodeReader&&) noexcept = default;
CodeReader& CodeReader::operator=(CodeReader&&) noexcept = default;

std::vector<Code> CodeReader::read(const cv::Mat& grey) {
  std::vector<Code> codes;
  if (grey.empty()) {
    return codes;
  }
  if (grey.dims != 2 || grey.type() != CV_8UC1) {
    throw common::Error("codes are read from grey pictures of 8 bits (8UC1); convert the picture first");
  }
  if (std::max(grey.cols, grey.rows) > kLargestSide) {
    throw common::Error(
        fmt::format("a picture of {} x {} pixels is too large to read codes from; scale it to at most {}",
                    grey.cols, grey.rows, kLargestSide));
  }
  // The smallest code, with pixels for modules; the libraries do not expect less.
  constexpr int kSmallestSide = 9;
  if (std::min(grey.cols, grey.rows) < kSmallestSide) {
    return codes;
  }
  if (config_.qr) {
    readQrCodes(grey, config_.qr_enlarge, codes);
  }
  if (tags_) {
    tags_->read(grey, codes);
  }
  return codes;
}

}  // namespace rubble::recognizer
