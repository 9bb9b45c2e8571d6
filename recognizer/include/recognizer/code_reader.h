#pragma once

#include <array>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "common/config.h"

namespace rubble::recognizer {

/// What is read, and with how much effort; units in visit().
struct CodeConfig {
  bool qr = true;
  double qr_enlarge = 2.0;
  bool apriltag = true;
  double tag_decimate = 1.5;
};

void visit(common::ConfigSection& section, CodeConfig& config);

/// A code in a picture.
struct Code {
  std::string kind;  // "qr" | "apriltag"
  std::string text;  // UTF-8; of a tag its number.
  /// The code's own top left, top right, bottom right, bottom left; pixels, the centre of the first one is 0.
  /// QR code: around its modules, without the quiet zone (printed with the usual four modules of it around n
  /// modules, the whole is (n + 8) / n as wide). AprilTag: around all 9 modules of a Standard41h12 with
  /// its outer ring of data (the library's own corners are those of the black and white border, 5 modules
  /// wide).
  std::array<cv::Point2f, 4> quad;
};

/// Reads QR codes (zxing-cpp) and AprilTags of the family Standard41h12 (Krogius, Haggenmiller, Olson:
/// Flexible layouts for fiducial tags, IROS 2019; libapriltag). All that are in the picture. The same
/// picture gives the same codes. One thread, provided that cv::setNumThreads() leaves OpenCV no more.
class CodeReader {
 public:
  explicit CodeReader(const CodeConfig& config = {});
  ~CodeReader();
  CodeReader(CodeReader&&) noexcept;
  CodeReader& operator=(CodeReader&&) noexcept;

  /// `grey`: 8UC1, at most kLargestSide pixels to a side; one without pixels holds no codes. Throws
  /// common::Error for other pictures.
  std::vector<Code> read(const cv::Mat& grey);

  static constexpr int kLargestSide = 16'384;

 private:
  class Tags;

  CodeConfig config_;
  std::unique_ptr<Tags> tags_;  // Null: not read.
};

}  // namespace rubble::recognizer
